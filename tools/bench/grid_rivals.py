#!/usr/bin/env python3
"""Parts of tools/bench/grids that need GDAL or VTK.

  grid_rivals.py make HEIGHTS.tif COLOUR.tif SIDE   makes a grid with noise of two steps and some holes
  grid_rivals.py view HEIGHTS.tif SCALE INFO.json   prints the eye and what it looks at, as options for a model of
                                                    which INFO.json tells the box
  grid_rivals.py run COMMAND...                     prints the seconds and the greatest MiB that a command takes
  grid_rivals.py mesh|coarse HEIGHTS.tif COLOUR SCALE SIZE REPEAT
      draws the grid as a mesh with VTK, or as what quadric clustering makes of it, and prints the seconds until the first
      picture, the milliseconds a frame, the triangles and the greatest MiB. COLOUR may be empty.
"""
import json
import math
import resource
import subprocess
import sys
import time


def greatest_mib(who):
    return resource.getrusage(who).ru_maxrss / 1024


def run(command):
    began = time.monotonic()
    done = subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    seconds = time.monotonic() - began
    print(f"{seconds:.4f} {greatest_mib(resource.RUSAGE_CHILDREN):.1f}")
    return done.returncode


def make(heights, colour, side):
    import numpy as np
    from osgeo import gdal
    row, column = np.mgrid[0:side, 0:side]
    z = 20000 + 3000 * np.sin(column / 170) * np.cos(row / 130) + 80 * np.sin(column / 11 + row / 17)
    random = np.random.default_rng(1)
    z = np.rint(z + random.normal(0, 2, z.shape)).astype(np.uint16)
    for x, y, radius in zip(*random.integers(0, side, (2, 40)), 2 ** random.uniform(0, math.log2(side / 64), 40)):
        z[np.hypot(column - x, row - y) < radius] = 0
    options = {"options": ["TILED=YES"]}
    file = gdal.GetDriverByName("GTiff").Create(heights, side, side, 1, gdal.GDT_UInt16, **options)
    file.SetGeoTransform((0, 1, 0, 0, 0, -1))
    file.GetRasterBand(1).SetNoDataValue(0)
    file.GetRasterBand(1).WriteArray(z)
    file = gdal.GetDriverByName("GTiff").Create(colour, side, side, 3, gdal.GDT_Byte, **options)
    for band, period in enumerate((90, 140, 230)):
        shade = 128 + 90 * np.sin(column / period + band) * np.sin(row / period) + random.normal(0, 3, z.shape)
        file.GetRasterBand(band + 1).WriteArray(shade.clip(0, 255).astype(np.uint8))


def read(path):
    """The numbers, which of them are valid, and the sides of a cell."""
    import numpy as np
    from osgeo import gdal
    file = gdal.Open(path)
    band = file.GetRasterBand(1)
    place = file.GetGeoTransform(can_return_null=True) or (0, 1, 0, 0, 0, -1)
    z = band.ReadAsArray()
    none = band.GetNoDataValue()
    valid = np.isfinite(z) if none is None else np.isfinite(z) & (z != none)
    return z, valid, abs(place[1]), abs(place[5])


def camera(path, scale):
    """Eye and look, from a side, as far off as a ball around the grid fills the picture's height. The grid's first
    sample is at 0, 0."""
    z, valid, dx, dy = read(path)
    rows, columns = z.shape
    low, high = float(z[valid].min()) * scale, float(z[valid].max()) * scale
    half = (dx * (columns - 1) / 2, dy * (rows - 1) / 2, (high - low) / 2)
    look = (half[0], -half[1], (low + high) / 2)
    away = math.hypot(*half) / math.sin(math.radians(22.5))
    way = (0.45, -0.65, 0.61)
    eye = [p + away * w / math.hypot(*way) for p, w in zip(look, way)]
    return eye, look


def view(path, scale, info):
    with open(info, encoding="utf-8") as file:
        box = json.load(file)
    corner = (box["box_min"][0], box["box_max"][1], 0)
    for name, point in zip(("--eye", "--look"), camera(path, scale)):
        print(name, ",".join(f"{p + c:.9g}" for p, c in zip(point, corner)))
    print("--up 0,0,1")


def mesh(path, colour, scale):
    """The filters of a mesh of the valid samples."""
    import numpy as np
    import vtk
    from osgeo import gdal
    from vtk.util.numpy_support import numpy_to_vtk
    z, valid, dx, dy = read(path)
    rows, columns = z.shape
    image = vtk.vtkImageData()
    image.SetDimensions(columns, rows, 1)
    image.SetSpacing(dx, dy, 1)
    image.SetOrigin(0, -dy * (rows - 1), 0)
    heights = np.where(valid, z * np.float32(scale), np.float32(-1e30)).astype(np.float32)[::-1].ravel()
    image.GetPointData().SetScalars(numpy_to_vtk(heights, deep=True))
    if colour:
        rgb = gdal.Open(colour).ReadAsArray()[:3].transpose(1, 2, 0)[::-1].reshape(-1, 3)
        array = numpy_to_vtk(np.ascontiguousarray(rgb), deep=True)
        array.SetName("rgb")
        image.GetPointData().AddArray(array)
    flat = vtk.vtkImageDataGeometryFilter()
    flat.SetInputData(image)
    last = flat
    if not valid.all():
        there = vtk.vtkThreshold()
        there.SetInputConnection(flat.GetOutputPort())
        there.SetUpperThreshold(-1e29)
        there.SetThresholdFunction(vtk.vtkThreshold.THRESHOLD_UPPER)
        last = vtk.vtkGeometryFilter()
        last.SetInputConnection(there.GetOutputPort())
    raised = vtk.vtkWarpScalar()
    raised.SetInputConnection(last.GetOutputPort())
    raised.UseNormalOn()
    raised.SetNormal(0, 0, 1)
    return raised


def coarser(last):
    """What vtkQuadricLODActor draws while a view moves. Its vertices have no colours."""
    import vtk
    triangles = vtk.vtkTriangleFilter()
    triangles.SetInputConnection(last.GetOutputPort())
    clusters = vtk.vtkQuadricClustering()
    clusters.SetInputConnection(triangles.GetOutputPort())
    clusters.SetNumberOfDivisions(256, 256, 256)
    clusters.AutoAdjustNumberOfDivisionsOff()
    clusters.CopyCellDataOff()
    return clusters


def draw(kind, path, colour, scale, size, repeat):
    import vtk
    began = time.monotonic()
    eye, look = camera(path, scale)
    last = mesh(path, colour, scale)
    if kind == "coarse":
        last = coarser(last)
        colour = ""
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(last.GetOutputPort())
    mapper.SetScalarVisibility(bool(colour))
    if colour:
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("rgb")
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    renderer = vtk.vtkRenderer()
    renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*(int(n) for n in size.split("x")))
    window.AddRenderer(renderer)
    lens = renderer.GetActiveCamera()
    lens.SetViewAngle(45)
    lens.SetPosition(*eye)
    lens.SetFocalPoint(*look)
    lens.SetViewUp(0, 0, 1)
    renderer.ResetCameraClippingRange()
    ends = [began]
    for _ in range(repeat + 1):
        window.Render()
        window.WaitForCompletion()
        ends.append(time.monotonic())
    frames = sorted(1000 * (b - a) for a, b in zip(ends[1:], ends[2:]))
    polygons = last.GetOutput().GetNumberOfPolys() * (1 if kind == "coarse" else 2)
    print(f"{ends[1] - began:.4f} {frames[len(frames) // 2]:.3f} {polygons} {greatest_mib(resource.RUSAGE_SELF):.1f}")


def main(arguments):
    if len(arguments) < 2 or arguments[0] == "--help":
        print(__doc__.strip())
        return 0 if arguments else 2
    what, rest = arguments[0], arguments[1:]
    if what == "run":
        return run(rest)
    if what == "make":
        make(rest[0], rest[1], int(rest[2]))
    elif what == "view":
        view(rest[0], float(rest[1]), rest[2])
    elif what in ("mesh", "coarse"):
        draw(what, rest[0], rest[1], float(rest[2]), rest[3], int(rest[4]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
