/* Tests LAZ: read through LASzip if the build has it; otherwise a sentence must say what to do. */
#include "tests/fixtures/las_fixture.h"

/* Makes the header of a compressed file of format 1, with LASzip's record and no real points. */
static void compressed(las_file *f, unsigned bits)
{
    const unsigned char content[46] = {2, 0, 0, 0, 3, 4};
    las_begin(f, 2, 1, 28);
    las_add_vlr(f, "laszip encoded", 22204, content, sizeof content);
    f->bytes[104] = (unsigned char)(1 | bits);
    las_put(f, 107, 4, 1000);
    f->size += 100;
}

#ifndef STP_HAVE_LASZIP

static void without_laszip(void **state)
{
    (void)state;
    las_file f;
    const unsigned bits[] = {0x80, 0xc0, 0x40};
    for (size_t i = 0; i < 3; i++) {
        compressed(&f, bits[i]);
        las_save(&f, "a.laz");
        scan_fixture_fails("a.laz", NULL, STP_UNSUPPORTED,
                           "is compressed LAS (LAZ), and this stipple was built without LASzip");
        scan_fixture_fails("a.laz", NULL, STP_UNSUPPORTED, "laszip -i in.laz -o out.las");
    }
}

#else

#include <laszip/laszip_api.h>

enum { COUNT = 120001 };

static void fill(laszip_point_struct *p, unsigned format, unsigned i)
{
    p->X = (int32_t)(i * 7919u) - 50000;
    p->Y = -(int32_t)(i % 1000);
    p->Z = (int32_t)(i / 3);
    p->intensity = (uint16_t)(i * 5);
    if (format >= 6) {
        p->extended_point_type = 1;
        p->extended_classification = (uint8_t)(i % 256);
        p->extended_classification_flags = i % 10 == 0 ? 4 : 0;
        p->extended_return_number = p->extended_number_of_returns = 1;
    }
    /* LASzip requires the two classes of the extended formats to agree, as far as five bits go */
    const unsigned class_id = format >= 6 ? i % 256 : i % 29;
    p->classification = class_id < 32 ? class_id & 31u : 0u;
    p->withheld_flag = i % 10 == 0;
    p->return_number = p->number_of_returns = 1;
    for (unsigned k = 0; k < 3; k++)
        p->rgb[k] = (uint16_t)(i * 3 + k);
}

/* Writes a file with LASzip itself. */
static void write_laz(const char *path, unsigned minor, unsigned format)
{
    laszip_POINTER writer = NULL;
    laszip_header_struct *header = NULL;
    laszip_point_struct *point = NULL;
    assert_int_equal(laszip_create(&writer), 0);
    assert_int_equal(laszip_get_header_pointer(writer, &header), 0);
    header->version_major = 1;
    header->version_minor = (laszip_U8)minor;
    header->header_size = (laszip_U16)las_header_bytes(minor);
    header->offset_to_point_data = header->header_size;
    header->point_data_format = (laszip_U8)format;
    header->point_data_record_length = (laszip_U16)las_record_bytes[format];
    if (minor >= 4)
        header->extended_number_of_point_records = COUNT;
    else
        header->number_of_point_records = COUNT;
    header->x_scale_factor = header->y_scale_factor = header->z_scale_factor = 0.5;
    assert_int_equal(laszip_open_writer(writer, path, 1), 0);
    assert_int_equal(laszip_get_point_pointer(writer, &point), 0);
    for (unsigned i = 0; i < COUNT; i++) {
        fill(point, format, i);
        assert_int_equal(laszip_write_point(writer), 0);
    }
    assert_int_equal(laszip_close_writer(writer), 0);
    assert_int_equal(laszip_destroy(writer), 0);
}

static void points_come_back(void **state)
{
    (void)state;
    const unsigned formats[][2] = {{2, 0}, {2, 1}, {2, 2}, {2, 3}, {4, 6}, {4, 7}, {4, 8}};
    for (size_t n = 0; n < sizeof formats / sizeof *formats; n++) {
        const unsigned minor = formats[n][0], format = formats[n][1];
        stp_scan_info info;
        write_laz("a.laz", minor, format);
        stp_point *points = scan_fixture_read("a.laz", NULL, &info);
        assert_int_equal(info.point_count, COUNT);
        for (unsigned i = 0; i < COUNT; i++) {
            laszip_point_struct p = {0};
            fill(&p, format, i);
            scan_fixture_position(&points[i], p.X * 0.5, p.Y * 0.5, p.Z * 0.5);
            scan_fixture_scalars(&points[i], p.intensity,
                                 format >= 6 ? p.extended_classification : p.classification);
            assert_int_equal(points[i].reject, i % 10 == 0 ? STP_REJECT_INVALID : STP_REJECT_NONE);
            if (las_rgb_at[format])
                scan_fixture_rgb(&points[i], p.rgb[0], p.rgb[1], p.rgb[2]);
        }
        free(points);
    }
}

/* A file cut in the middle, and one of a header alone. */
static void damaged(void **state)
{
    (void)state;
    las_file f;
    compressed(&f, 0x80);
    las_save(&f, "b.laz");
    scan_fixture_fails("b.laz", NULL, STP_CORRUPT, "LASzip could not");
    write_laz("a.laz", 2, 1);
    assert_int_equal(truncate("a.laz", 20000), 0);
    scan_fixture_fails("a.laz", NULL, STP_CORRUPT, "LASzip could not");
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
#ifndef STP_HAVE_LASZIP
        cmocka_unit_test(without_laszip),
#else
        cmocka_unit_test(points_come_back),
        cmocka_unit_test(damaged),
#endif
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
