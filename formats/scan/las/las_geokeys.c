/* Prints the GeoTIFF keys of a LAS file as readable text. */
#include "formats/scan/las/las_geokeys.h"

#include "formats/scan/las/las_bytes.h"

/* Tags that say where a key's value is; 0: in the key itself. */
enum { IN_DIRECTORY = 34735, IN_DOUBLES = 34736, IN_ASCII = 34737 };

typedef struct geo_key {
    uint16_t id, location, count, value;
} geo_key;

typedef struct key_name {
    uint16_t id;
    const char *name;
} key_name;

static const key_name names[] = {
    {1024, "GTModelTypeGeoKey"},
    {1025, "GTRasterTypeGeoKey"},
    {1026, "GTCitationGeoKey"},
    {2048, "GeographicTypeGeoKey"},
    {2049, "GeogCitationGeoKey"},
    {2050, "GeogGeodeticDatumGeoKey"},
    {2051, "GeogPrimeMeridianGeoKey"},
    {2052, "GeogLinearUnitsGeoKey"},
    {2053, "GeogLinearUnitSizeGeoKey"},
    {2054, "GeogAngularUnitsGeoKey"},
    {2055, "GeogAngularUnitSizeGeoKey"},
    {2056, "GeogEllipsoidGeoKey"},
    {2057, "GeogSemiMajorAxisGeoKey"},
    {2058, "GeogSemiMinorAxisGeoKey"},
    {2059, "GeogInvFlatteningGeoKey"},
    {2060, "GeogAzimuthUnitsGeoKey"},
    {2061, "GeogPrimeMeridianLongGeoKey"},
    {2062, "GeogTOWGS84GeoKey"},
    {3072, "ProjectedCSTypeGeoKey"},
    {3073, "PCSCitationGeoKey"},
    {3074, "ProjectionGeoKey"},
    {3075, "ProjCoordTransGeoKey"},
    {3076, "ProjLinearUnitsGeoKey"},
    {3077, "ProjLinearUnitSizeGeoKey"},
    {3078, "ProjStdParallel1GeoKey"},
    {3079, "ProjStdParallel2GeoKey"},
    {3080, "ProjNatOriginLongGeoKey"},
    {3081, "ProjNatOriginLatGeoKey"},
    {3082, "ProjFalseEastingGeoKey"},
    {3083, "ProjFalseNorthingGeoKey"},
    {3084, "ProjFalseOriginLongGeoKey"},
    {3085, "ProjFalseOriginLatGeoKey"},
    {3086, "ProjFalseOriginEastingGeoKey"},
    {3087, "ProjFalseOriginNorthingGeoKey"},
    {3088, "ProjCenterLongGeoKey"},
    {3089, "ProjCenterLatGeoKey"},
    {3090, "ProjCenterEastingGeoKey"},
    {3091, "ProjCenterNorthingGeoKey"},
    {3092, "ProjScaleAtNatOriginGeoKey"},
    {3093, "ProjScaleAtCenterGeoKey"},
    {3094, "ProjAzimuthAngleGeoKey"},
    {3095, "ProjStraightVertPoleLongGeoKey"},
    {4096, "VerticalCSTypeGeoKey"},
    {4097, "VerticalCitationGeoKey"},
    {4098, "VerticalDatumGeoKey"},
    {4099, "VerticalUnitsGeoKey"},
};

static stp_status add_name(stp_las_text *text, uint16_t id, stp_error *err)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (names[i].id == id)
            return stp_las_text_add(text, err, "%s=", names[i].name);
    return stp_las_text_add(text, err, "Key%u=", id);
}

static stp_status add_doubles(stp_las_text *text, const geo_key *key, const stp_las_record *doubles,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const size_t there = doubles->length / 8;
    if ((size_t)key->value + key->count > there)
        return stp_las_text_add(text, err, "(missing: numbers %u to %u of %zu)", key->value + 1u,
                                (unsigned)key->value + key->count, there);
    for (unsigned i = 0; i < key->count && !text->full; i++)
        STP_TRY(stp_las_text_add(text, err, "%s%.15g", i > 0 ? "," : "",
                                 stp_las_double(doubles->bytes + 8 * ((size_t)key->value + i))));
done:
    return status;
}

/* Adds a text. It ends in `|`, which is not part of it. */
static stp_status add_ascii(stp_las_text *text, const geo_key *key, const stp_las_record *ascii,
                            stp_error *err)
{
    size_t count = key->count;
    if (key->value + count > ascii->length)
        return stp_las_text_add(text, err, "(missing: characters %u to %u of %zu)", key->value + 1u,
                                (unsigned)key->value + key->count, ascii->length);
    while (count > 0 && (ascii->bytes[key->value + count - 1] == '|' ||
                         ascii->bytes[key->value + count - 1] == '\0'))
        count--;
    if (count == 0) /* there may be no record at all */
        return STP_OK;
    return stp_las_text_add_bytes(text, ascii->bytes + key->value, count, err);
}

/* Adds 16-bit numbers that follow the keys: the directory itself may hold values. */
static stp_status add_shorts(stp_las_text *text, const geo_key *key,
                             const stp_las_record *directory, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t there = directory->length / 2;
    if ((size_t)key->value + key->count > there)
        return stp_las_text_add(text, err, "(missing: numbers %u to %u of %zu)", key->value + 1u,
                                (unsigned)key->value + key->count, there);
    for (unsigned i = 0; i < key->count && !text->full; i++)
        STP_TRY(stp_las_text_add(text, err, "%s%u", i > 0 ? "," : "",
                                 stp_las_u16(directory->bytes + 2 * ((size_t)key->value + i))));
done:
    return status;
}

static stp_status add_value(stp_las_text *text, const geo_key *key, const stp_las_records *records,
                            stp_error *err)
{
    switch (key->location) {
    case 0:
        return stp_las_text_add(text, err, "%u", key->value);
    case IN_DOUBLES:
        return add_doubles(text, key, &records->kept[STP_LAS_GEO_DOUBLES], err);
    case IN_ASCII:
        return add_ascii(text, key, &records->kept[STP_LAS_GEO_ASCII], err);
    case IN_DIRECTORY:
        return add_shorts(text, key, &records->kept[STP_LAS_GEO_KEYS], err);
    default:
        return stp_las_text_add(text, err, "(missing: in tag %u)", key->location);
    }
}

stp_status stp_las_geokeys_text(stp_las_text *text, const stp_las_records *records, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_las_record *directory = &records->kept[STP_LAS_GEO_KEYS];
    if (directory->length < 8)
        return STP_OK;
    const unsigned declared = stp_las_u16(directory->bytes + 6);
    const size_t there = directory->length / 8 - 1;
    for (size_t i = 0; i < declared && i < there && !text->full; i++) {
        const unsigned char *at = directory->bytes + 8 * (i + 1);
        const geo_key key = {stp_las_u16(at), stp_las_u16(at + 2), stp_las_u16(at + 4),
                             stp_las_u16(at + 6)};
        STP_TRY(stp_las_text_add(text, err, "%s", i > 0 ? "\n" : ""));
        STP_TRY(add_name(text, key.id, err));
        STP_TRY(add_value(text, &key, records, err));
    }
    if (declared > there)
        STP_TRY(stp_las_text_add(text, err, "%s(missing: keys %zu to %u)", there > 0 ? "\n" : "",
                                 there + 1, declared));
done:
    return status;
}
