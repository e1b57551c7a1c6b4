#!/usr/bin/env python3
"""Opens the files of a run with the real VTK readers and compares them with the run's manifest.

    python tests/vtk/check.py out/fig03            every .pvd in the folder
    python tests/vtk/check.py out/fig03/fig03.pvd  one series

Needs the `vtk` wheel (vtk==9.7.2). Exit status: 0 all good, 1 a check failed, 2 nothing to check or no VTK.

For each entry of a .pvd: the reader reports no error; extent, spacing, origin and arrays are sound; every value is
finite; times ascend and equal the TimeValue field data. With `<run>.manifest.json` beside `<run>.pvd`, geometry must
equal it exactly, and min, max and sum of every array to 1e-12 (Float64) or 1e-6 (Float32) of the mean magnitude.
"""

import json
import math
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkStringOutputWindow, vtkOutputWindow
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader
except ImportError as missing:
    print(f"check.py needs the vtk wheel ({missing}); run: pip install vtk==9.7.2", file=sys.stderr)
    sys.exit(2)

TOLERANCE = {8: 1e-12, 4: 1e-6}
READERS = {".vti": vtkXMLImageDataReader, ".vtp": vtkXMLPolyDataReader}


class Wrong(Exception):
    """A file that is not as it should be; the text says how."""


def demand(condition, sentence):
    if not condition:
        raise Wrong(sentence)


def read(path):
    """The data set of a file; whatever VTK complains about is an error."""
    demand(path.is_file(), "the file does not exist")
    demand(path.suffix in READERS, f"no reader for {path.suffix}")
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    reader = READERS[path.suffix]()
    reader.SetFileName(str(path))
    reader.Update()
    complaints = window.GetOutput().strip()
    demand(not complaints, f"VTK says: {complaints}")
    demand(reader.GetErrorCode() == 0, f"VTK reports error code {reader.GetErrorCode()}")
    return reader.GetOutput()


def arrays_of(attributes, tuples):
    """Arrays by name, each checked for its length and for values that are not finite."""
    found = {}
    for n in range(attributes.GetNumberOfArrays()):
        array = attributes.GetArray(n)
        demand(array is not None, f"array {n} is not numeric")
        name = array.GetName()
        demand(name, f"array {n} has no name")
        demand(name not in found, f"two arrays are called '{name}'")
        demand(array.GetNumberOfTuples() == tuples, f"'{name}' has {array.GetNumberOfTuples()} tuples, not {tuples}")
        values = vtk_to_numpy(array)
        bad = int(np.count_nonzero(~np.isfinite(values)))
        demand(bad == 0, f"'{name}' has {bad} values that are not finite")
        found[name] = values
    return found


def time_of(data):
    array = data.GetFieldData().GetArray("TimeValue")
    demand(array is not None and array.GetNumberOfValues() == 1, "there is no single TimeValue in the field data")
    return array.GetValue(0)


def compare(name, values, expected):
    """Minimum, maximum and sum against the manifest, relative to the size of the values."""
    demand(expected.get("nonfinite", 0) == 0, f"the manifest says '{name}' has values that are not finite")
    if values.size == 0:
        return
    tolerance = TOLERANCE[values.dtype.itemsize]
    wide = values.astype(np.float64, copy=False)
    measured = {"min": wide.min(), "max": wide.max(), "sum": math.fsum(wide.ravel())}
    scale = {"min": np.abs(wide).max(), "max": np.abs(wide).max(), "sum": np.abs(wide).sum()}
    for key, value in measured.items():
        demand(key in expected and expected[key] is not None, f"the manifest has no {key} of '{name}'")
        off = abs(value - expected[key])
        demand(off <= tolerance * scale[key], f"{key} of '{name}' is {value!r}, the manifest says {expected[key]!r}")


def check_file(path, entry):
    """Checks one file; returns its time and a short description."""
    data = read(path)
    if path.suffix == ".vti":
        extent, spacing, origin = data.GetExtent(), data.GetSpacing(), data.GetOrigin()
        demand(all(extent[2 * a] < extent[2 * a + 1] for a in range(3)), f"extent {extent} has no cells")
        demand(all(math.isfinite(h) and h > 0 for h in spacing), f"spacing {spacing} is not positive")
        demand(all(math.isfinite(o) for o in origin), f"origin {origin} is not finite")
        arrays = arrays_of(data.GetCellData(), data.GetNumberOfCells())
        demand(arrays, "there is no cell data")
        geometry = {"extent": list(extent), "origin": list(origin), "spacing": list(spacing)}
        about = " x ".join(str(extent[2 * a + 1] - extent[2 * a]) for a in range(3)) + " cells"
    else:
        count = data.GetNumberOfPoints()
        demand(data.GetNumberOfVerts() == count, f"{count} points have {data.GetNumberOfVerts()} vertices")
        arrays = arrays_of(data.GetPointData(), count)
        points = vtk_to_numpy(data.GetPoints().GetData()) if count else np.zeros((0, 3))
        demand(np.isfinite(points).all(), "positions are not finite")
        geometry = {"points": count}
        about = f"{count} points"
        if entry is not None:
            compare("positions", points, entry["positions"])
    time = time_of(data)
    if entry is not None:
        demand(entry["time"] == time, f"TimeValue is {time!r}, the manifest says {entry['time']!r}")
        for key, value in geometry.items():
            demand(entry.get(key) == value, f"{key} is {value}, the manifest says {entry.get(key)}")
        names = list(entry["arrays"])
        demand(names == list(arrays), f"arrays are {list(arrays)}, the manifest says {names}")
        for name, values in arrays.items():
            compare(name, values, entry["arrays"][name])
    return time, f"{about}, {', '.join(arrays) or 'no arrays'}"


def check_series(path):
    """Checks a .pvd and everything it lists; returns the number of files."""
    entries = ElementTree.parse(path).getroot().findall("./Collection/DataSet")
    demand(entries, "the series is empty")
    manifest_path = path.with_suffix(".manifest.json")
    manifest = None
    if manifest_path.exists():
        manifest = {entry["file"]: entry for entry in json.loads(manifest_path.read_text())["files"]}
    seen, last = set(), (-math.inf, -1)
    for entry in entries:
        name = entry.attrib["file"]
        step = (float(entry.attrib["timestep"]), int(entry.attrib["part"]))
        try:
            demand(not Path(name).is_absolute(), "the path is not relative")
            demand(name not in seen, "the file is listed twice")
            demand(step > last, f"time and part {step} do not follow {last}")
            expected = None
            if manifest is not None:
                demand(Path(name).name in manifest, "the manifest does not know the file")
                expected = manifest[Path(name).name]
            time, about = check_file(path.parent / name, expected)
            demand(time == step[0], f"TimeValue is {time!r}, the series says {step[0]!r}")
        except Wrong as wrong:
            raise Wrong(f"{name}: {wrong}") from None
        seen.add(name)
        last = step
        print(f"  {name}: t = {time!r}, {about}")
    if manifest is not None:
        missing = sorted(set(manifest) - {Path(name).name for name in seen})
        demand(not missing, f"the manifest lists files that the series does not: {', '.join(missing)}")
    return len(entries)


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    target = Path(arguments[0])
    series = sorted(target.rglob("*.pvd")) if target.is_dir() else [target]
    if not series or not all(path.is_file() for path in series):
        print(f"{target}: no .pvd here", file=sys.stderr)
        return 2
    failed = False
    for path in series:
        try:
            print(f"{path}: {check_series(path)} files are sound")
        except Wrong as wrong:
            print(f"FAILED {path}: {wrong}", file=sys.stderr)
            failed = True
        except (ElementTree.ParseError, ValueError, KeyError, TypeError) as damage:
            print(f"FAILED {path}: not a readable series or manifest: {damage!r}", file=sys.stderr)
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
