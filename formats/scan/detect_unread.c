/* Names known formats that are not read here. */
#include "formats/scan/detect_unread.h"

#include "base/file.h"

#include <stdbool.h>
#include <string.h>
#include <strings.h>

#define ADVICE_GRID "heights are read as TIFF, PNG, EXR, PFM or PGM, and colours by --colour"
#define ADVICE_RASTER "if it holds heights, make a GeoTIFF of them (gdal_translate)"
#define ADVICE_MESH "convert it to PLY or OBJ (Blender and MeshLab do)"
#define ADVICE_HEIGHTS "export its heights as TIFF, or as text with one x y z a line"
#define ADVICE_TILES "give the scan that it was made of"
#define ADVICE_BAG "write its clouds as PCD"
#define ADVICE_PACKETS "export its frames as PCD, LAS or CSV (the lidar's own viewer does)"

typedef struct known {
    const char *magic;
    size_t length;
    const char *name, *advice;
    bool binary; /* the magic is a word that text may begin with: some byte must be 0 */
} known;

static const known contents[] = {
    {"STIPPLE", 8, "a chunk file of ours", "view it, or export its points to make another", false},
    {"\xff\xd8\xff", 3, "a picture (JPEG)", ADVICE_GRID, false},
    {"PF\n", 3, "a picture of colours in floats (PFM)", ADVICE_GRID, false},
    {"GIF8", 4, "a picture (GIF)", ADVICE_GRID, true},
    {"CDF", 3, "a NetCDF file", ADVICE_RASTER, false},
    {"\x89HDF\r\n", 6, "an HDF5 file", ADVICE_RASTER, false},
    {"EHFA_HEADER_TAG", 15, "an ERDAS Imagine file", ADVICE_RASTER, false},
    {"UHL1", 4, "a DTED tile", ADVICE_RASTER, false},
    {"GWYP", 4, "a Gwyddion file", ADVICE_HEIGHTS, true},
    {"DIGITAL SURF", 12, "a surface (Digital Surf)", ADVICE_HEIGHTS, true},
    {"DSCOMPRESSED", 12, "a surface (Digital Surf)", ADVICE_HEIGHTS, true},
    {"aISO-1.0", 8, "a surface (SDF)", ADVICE_HEIGHTS, false},
    {"bISO-1.0", 8, "a surface (SDF)", ADVICE_HEIGHTS, false},
    {"VK4_", 4, "a microscope's file (Keyence)", ADVICE_HEIGHTS, true},
    {"\x88\x1b\x03\x6f", 4, "a surface (Zygo)", ADVICE_HEIGHTS, false},
    {"ZISRAWFILE", 10, "a microscope's file (CZI)", ADVICE_HEIGHTS, true},
    {"MATLAB 5.0", 10, "a MATLAB file", "write its points as text (writematrix)", false},
    {"PAR1", 4, "a table (Parquet)", "write it as CSV", true},
    {"CCB", 3, "a project (CloudCompare)", "save its clouds as PLY or LAS", true},
    {"DRACO", 5, "a Draco file", "unpack it first (draco_decoder)", false},
    {"BLENDER", 7, "a scene (Blender)", "export it as PLY or OBJ", false},
    {"ISO-10303-21", 12, "a CAD model (STEP)", "make a mesh of it as STL (FreeCAD does)", false},
    {"AC10", 4, "a drawing (DWG)", "export its points as text, or its faces as OBJ", true},
    {"#VRML", 5, "a scene (VRML)", ADVICE_MESH, false},
    {"PXR-USDC", 8, "a scene (USD)", ADVICE_MESH, false},
    {"#usda", 5, "a scene (USD)", ADVICE_MESH, false},
    {"Kaydara FBX", 11, "a scene (FBX)", ADVICE_MESH, false},
    {"; FBX", 5, "a scene (FBX)", ADVICE_MESH, false},
    {"# vtk DataFile", 14, "a VTK file", "convert it to PLY (ParaView does)", false},
    {"b3dm", 4, "a tile (3D Tiles)", ADVICE_TILES, true},
    {"i3dm", 4, "a tile (3D Tiles)", ADVICE_TILES, true},
    {"pnts", 4, "a tile (3D Tiles)", ADVICE_TILES, true},
    {"cmpt", 4, "a tile (3D Tiles)", ADVICE_TILES, true},
    {"#ROSBAG", 7, "a ROS bag", "write its clouds as PCD (bag_to_pcd of pcl_ros)", false},
    {"\x89MCAP", 5, "a ROS bag (MCAP)", ADVICE_BAG, false},
    {"SQLite format 3", 15, "a database (SQLite)", "if it is a ROS bag, " ADVICE_BAG, false},
    {"\xd4\xc3\xb2\xa1", 4, "a record of packets (PCAP)", ADVICE_PACKETS, false},
    {"\x4d\x3c\xb2\xa1", 4, "a record of packets (PCAP)", ADVICE_PACKETS, false},
    {"\x0a\x0d\x0d\x0a", 4, "a record of packets (PCAP)", ADVICE_PACKETS, true},
    {"%PDF", 4, "a document (PDF)", "give the scan itself", false},
    {"version https://git-lfs", 23, "a pointer of Git LFS", "fetch the scan itself (git lfs pull)",
     false},
    {"\x1f\x8b\x08", 3, "compressed with gzip", "unpack it first (gunzip)", false},
    {"BZh", 3, "compressed with bzip2", "unpack it first (bunzip2)", false},
    {"\xfd"
     "7zXZ",
     5, "compressed with xz", "unpack it first (unxz)", false},
    {"\x28\xb5\x2f\xfd", 4, "compressed with zstd", "unpack it first (unzstd)", false},
    {"7z\xbc\xaf", 4, "a 7-Zip archive", "unpack it first (7z x)", false},
    {"Rar!", 4, "a RAR archive", "unpack it first (unrar x)", true},
    {"PK\x03\x04", 4, "a ZIP archive", "unpack it first (unzip)", false},
};

static const struct {
    const char *ending, *name, *advice;
} endings[] = {
    {".json", "JSON", "of an EPT give ept.json; else write points as text, one x y z a line"},
    {".geojson", "JSON", "write its points as text, one x y z a line"},
    {".rcp", "a scan (ReCap)", "export it as E57 or PTS"},
    {".rcs", "a scan (ReCap)", "export it as E57 or PTS"},
    {".fls", "a scan (FARO)", "export it as E57 (SCENE does)"},
    {".zfs", "a scan (Z+F)", "export it as E57 (LaserControl does)"},
    {".rxp", "a scan (Riegl)", "export it as LAS or E57 (RiSCAN PRO does)"},
    {".rdbx", "a scan (Riegl)", "export it as LAS or E57 (RiSCAN PRO does)"},
    {".3dd", "a scan (Riegl)", "export it as LAS or E57 (RiSCAN PRO does)"},
    {".imp", "a database (Cyclone)", "export it as E57 or PTX"},
    {".splat", "a scene of Gaussian splats", "export them as PLY (SuperSplat does)"},
    {".ksplat", "a scene of Gaussian splats", "export them as PLY (SuperSplat does)"},
    {".spz", "a scene of Gaussian splats", "export them as PLY (SuperSplat does)"},
    {".sog", "a scene of Gaussian splats", "export them as PLY (SuperSplat does)"},
    {".npz", "an archive of arrays (NumPy)", "unpack it first (unzip): .npy is read"},
    {".usdz", "a scene (USD)", ADVICE_MESH},
    {".3mf", "a mesh (3MF)", ADVICE_MESH},
    {".3ds", "a scene (3DS)", ADVICE_MESH},
    {".osgb", "a scene (OpenSceneGraph)", ADVICE_MESH},
    {".skp", "a scene (SketchUp)", ADVICE_MESH},
    {".dxf", "a drawing (DXF)", "export its points as text, or its faces as OBJ"},
    {".igs", "a CAD model (IGES)", "make a mesh of it as STL (FreeCAD does)"},
    {".iges", "a CAD model (IGES)", "make a mesh of it as STL (FreeCAD does)"},
    {".slpk", "a scene layer (I3S)", ADVICE_TILES},
    {".x3p", "a surface (X3P)", ADVICE_HEIGHTS},
    {".plux", "a surface (Sensofar)", ADVICE_HEIGHTS},
    {".opd", "a surface (Bruker)", ADVICE_HEIGHTS},
    {".flt", "a raster of plain numbers", ADVICE_RASTER},
    {".bil", "a raster of plain numbers", ADVICE_RASTER},
    {".adf", "a raster (ArcInfo)", ADVICE_RASTER},
    {".dem", "a raster (DEM)", ADVICE_RASTER},
    {".bmp", "a picture (BMP)", ADVICE_GRID},
    {".webp", "a picture (WebP)", ADVICE_GRID},
    {".heic", "a picture (HEIC)", ADVICE_GRID},
    {".jp2", "a picture (JPEG 2000)", ADVICE_RASTER},
};

static bool starts_with(const char *bytes, size_t length, const char *word)
{
    return length >= strlen(word) && strncasecmp(bytes, word, strlen(word)) == 0;
}

static bool holds(const char *bytes, size_t length, const char *word)
{
    return memmem(bytes, length, word, strlen(word)) != NULL;
}

/* XML and JSON, whose words tell more than their begin. */
static const char *marked_up(const char *bytes, size_t length, const char **advice)
{
    while (length > 0 && strchr(" \t\r\n", *bytes) && *bytes != '\0') {
        bytes++;
        length--;
    }
    const bool json = length > 0 && *bytes == '{';
    *advice = ADVICE_TILES;
    if (json && holds(bytes, length, "\"geometricError\""))
        return "a tileset (3D Tiles)";
    if (json &&
        (holds(bytes, length, "\"octreeDir\"") || holds(bytes, length, "\"firstChunkSize\"")))
        return "a cloud of Potree";
    if (starts_with(bytes, length, "<!DOCTYPE html") || starts_with(bytes, length, "<html")) {
        *advice = "it came in place of a file: fetch the scan again";
        return "a web page";
    }
    if (starts_with(bytes, length, "<!DOCTYPE MeshLab")) {
        *advice = "give the meshes that it names";
        return "a project (MeshLab)";
    }
    *advice = "export its points as PLY or LAS, or its faces as OBJ";
    return starts_with(bytes, length, "<?xml") ? "XML" : NULL;
}

const char *stp_unread_content(const char *bytes, size_t length, const char *name,
                               const char **advice)
{
    const bool zeros = length > 0 && memchr(bytes, '\0', length) != NULL;
    for (size_t i = 0; i < sizeof contents / sizeof *contents; i++) {
        const known *k = &contents[i];
        if (length < k->length || memcmp(bytes, k->magic, k->length) != 0 || (k->binary && !zeros))
            continue;
        const bool packed = bytes[0] == 'P' && bytes[1] == 'K';
        const char *told = packed || bytes[0] == '\x1f' ? stp_unread_name(name, advice) : NULL;
        *advice = told ? *advice : k->advice;
        return told ? told : k->name;
    }
    return marked_up(bytes, length, advice);
}

const char *stp_unread_name(const char *name, const char **advice)
{
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (stp_path_ends_in(name, endings[i].ending)) {
            *advice = endings[i].advice;
            return endings[i].name;
        }
    return NULL;
}
