/* Tests E57 files that are cut, damaged or hostile: each must give one sentence and no crash. */
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#define XYZ                                                                                        \
    E57_FLOAT("cartesianX", "double")                                                              \
    E57_FLOAT("cartesianY", "double") E57_FLOAT("cartesianZ", "single")
#define POINTS 200u

/* A sound file with two packets and five pages of points. */
static e57_file sound_file(void)
{
    e57_file file;
    e57_stream s[4] = {{.part = 800}, {.part = 800}, {.part = 400}, {.part = 200}};
    for (unsigned i = 0; i < POINTS; i++) {
        bytes_double(&s[0].bytes, i);
        bytes_double(&s[1].bytes, 2.0 * i);
        bytes_float(&s[2].bytes, 3.0f);
        bytes_bits(&s[3].bytes, i, 12);
    }
    e57_begin(&file);
    e57_vector(&file, s, 4, false);
    e57_scan(&file,
             "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">1</w>"
             "</rotation></pose><intensityLimits type=\"Structure\"><intensityMaximum "
             "type=\"Integer\">4095</intensityMaximum></intensityLimits>\n",
             POINTS, XYZ E57_INTEGER("intensity", "0", "4095"));
    e57_end(&file, "");
    for (int i = 0; i < 4; i++)
        bytes_free(&s[i].bytes);
    return file;
}

static void the_file_is_sound(void **state)
{
    (void)state;
    e57_file file = sound_file();
    stp_scan_info info;
    e57_write("bad.e57", &file);
    stp_point *p = scan_fixture_read("bad.e57", NULL, &info);
    assert_int_equal(info.point_count, POINTS);
    for (unsigned i = 0; i < POINTS; i++) {
        scan_fixture_position(&p[i], i, 2.0 * i, 3.0);
        assert_int_equal(p[i].intensity, (unsigned)(i * 65535.0 / 4095.0 + 0.5));
    }
    free(p);
    e57_free(&file);
}

/* Flips a bit of a page or of its checksum: the message must name the page by its offset. */
static void bad_pages(void **state)
{
    (void)state;
    e57_file file = sound_file();
    byte_row sealed = e57_seal(file.logical.data, file.logical.size);
    assert_true(sealed.size >= 6 * 1024u);
    for (size_t page = 0; page < sealed.size / 1024; page++) {
        static const size_t places[] = {16, 500, 1019, 1020, 1023};
        for (size_t i = page == 0 ? 2 : 0; i < sizeof places / sizeof *places; i++) {
            char text[80];
            snprintf(text, sizeof text, "the page at byte %zu has checksum", page * 1024);
            sealed.data[page * 1024 + places[i]] ^= 4;
            scan_fixture_bytes("bad.e57", sealed.data, sealed.size);
            scan_fixture_fails("bad.e57", NULL, STP_CORRUPT, text);
            sealed.data[page * 1024 + places[i]] ^= 4;
        }
    }
    bytes_free(&sealed);
    e57_free(&file);
}

static void cut_files(void **state)
{
    (void)state;
    e57_file file = sound_file();
    byte_row sealed = e57_seal(file.logical.data, file.logical.size);
    for (size_t size = 8; size < sealed.size; size += size % 1024 < 8 ? 1 : 251) {
        scan_fixture_bytes("bad.e57", sealed.data, size);
        scan_fixture_fails("bad.e57", NULL, STP_CORRUPT, "cut");
    }
    bytes_free(&sealed);
    e57_free(&file);
}

/* A false number in the file, under a right checksum. */
typedef struct lie {
    size_t at;
    uint64_t value;
    size_t size;
    stp_status status;
    const char *text;
} lie;

static void check_lies(const lie *lies, size_t count, size_t from_section, size_t from_packet)
{
    for (size_t i = 0; i < count; i++) {
        e57_file file = sound_file();
        const size_t base = from_section ? file.section : (from_packet ? file.packet : 0);
        bytes_set(&file.logical, base + lies[i].at, lies[i].value, lies[i].size);
        e57_write("bad.e57", &file);
        scan_fixture_fails("bad.e57", NULL, lies[i].status, lies[i].text);
        e57_free(&file);
    }
}

static void header_lies(void **state)
{
    (void)state;
    static const lie lies[] = {
        {8, 2, 4, STP_VERSION, "version 2.0"},
        {40, 512, 8, STP_UNSUPPORTED, "512"},
        {40, 0, 8, STP_UNSUPPORTED, "pages of 0 bytes"},
        {16, 0, 8, STP_CORRUPT, "says 0"},
        {16, 1024 * 1024, 8, STP_CORRUPT, "says 1048576"},
        {16, 1025, 8, STP_CORRUPT, "says 1025"},
        {16, UINT64_MAX, 8, STP_CORRUPT, "18446744073709551615"},
        {16, 1024, 8, STP_CORRUPT, "behind the file's end"},
        {24, 1022, 8, STP_CORRUPT, "inside a page's checksum"},
        {24, UINT64_MAX, 8, STP_CORRUPT, "18446744073709551615"},
        {24, UINT64_MAX - 1023, 8, STP_CORRUPT, "behind the file's end"},
        {24, 0, 8, STP_CORRUPT, "XML section, line 1"},
        {32, 0, 8, STP_CORRUPT, "XML section, line 1"},
        {32, 100000, 8, STP_CORRUPT, "100000 bytes"},
        {32, UINT64_MAX, 8, STP_CORRUPT, "18446744073709551615"},
        {0, 0, 1, STP_FORMAT, "no known format"},
    };
    check_lies(lies, sizeof lies / sizeof *lies, 0, 0);
}

static void section_lies(void **state)
{
    (void)state;
    static const lie lies[] = {
        {0, 2, 1, STP_CORRUPT, "a section of kind 2"},
        {8, 0, 8, STP_CORRUPT, "a section of 0 bytes"},
        {8, 31, 8, STP_CORRUPT, "a section of 31 bytes"},
        {8, UINT64_MAX, 8, STP_CORRUPT, "18446744073709551615"},
        {8, UINT64_MAX - 40, 8, STP_CORRUPT, "does not fit"},
        {16, 0, 8, STP_CORRUPT, "first packet at byte 0"},
        {16, 76, 8, STP_CORRUPT, "first packet at byte 76"},
        {16, 1021, 8, STP_CORRUPT, "inside a page's checksum"},
        {16, UINT64_MAX, 8, STP_CORRUPT, "18446744073709551615"},
        {16, 5 * 1024, 8, STP_CORRUPT, "does not fit"},
        {16, 84, 8, STP_CORRUPT, "a packet of points"},
    };
    check_lies(lies, sizeof lies / sizeof *lies, 1, 0);
}

static void packet_lies(void **state)
{
    (void)state;
    static const lie lies[] = {
        {0, 3, 1, STP_CORRUPT, "byte 80: a packet of points is of no known kind (found 3)"},
        {0, 0, 1, STP_CORRUPT, "after 100 of its 200"}, /* an index: just one packet is left */
        {0, 2, 1, STP_CORRUPT, "after 100 of its 200"},
        {2, 0, 2, STP_CORRUPT, "no multiple of 4"},
        {2, 3, 2, STP_CORRUPT, "too small for its header"},
        {2, 7, 2, STP_CORRUPT, "too small for the sizes"},
        {2, 15, 2, STP_CORRUPT, "longer than it is"},
        {2, 65535, 2, STP_CORRUPT, "leaves its section (found 65536)"},
        {4, 3, 2, STP_CORRUPT, "not as many bytestreams as the scan has fields (found 3)"},
        {4, 5, 2, STP_CORRUPT, "(found 5)"},
        {4, 65535, 2, STP_CORRUPT, "(found 65535)"},
        {6, 65535, 2, STP_CORRUPT, "longer than it is"},
        {12, 65535, 2, STP_CORRUPT, "longer than it is"},
        {6, 799, 2, STP_CORRUPT, "after 199 of its 200"},
        {10, 0, 2, STP_CORRUPT, "after 100 of its 200"},
    };
    check_lies(lies, sizeof lies / sizeof *lies, 0, 1);
}

/* A section that ends before its packets do, at every size. */
static void cut_sections(void **state)
{
    (void)state;
    e57_file whole = sound_file();
    uint64_t size;
    memcpy(&size, whole.logical.data + whole.section + 8, sizeof size);
    for (uint64_t cut = 0; cut < size; cut += cut < 200 || cut > size - 50 ? 1 : 13) {
        e57_file file = sound_file();
        bytes_set(&file.logical, file.section + 8, cut, 8);
        e57_write("bad.e57", &file);
        scan_fixture_fails("bad.e57", NULL, STP_CORRUPT, "the file is damaged");
        e57_free(&file);
    }
    e57_free(&whole);
}

/* Replaces the first `from` in the XML; the rest of the file stays as it was. */
static void replace_xml(e57_file *file, const char *from, const char *to)
{
    const size_t xml = file->logical.size - file->xml.size;
    bytes_add(&file->xml, "", 1);
    char *found = strstr((char *)file->xml.data, from);
    assert_non_null(found);
    const size_t before = (size_t)(found - (char *)file->xml.data);
    byte_row row = {0};
    bytes_add(&row, file->logical.data, xml);
    bytes_add(&row, file->xml.data, before);
    bytes_text(&row, to);
    bytes_text(&row, found + strlen(from));
    bytes_set(&row, 32, row.size - xml, 8);
    bytes_set(&row, 16, (row.size + 1019) / 1020 * 1024, 8);
    bytes_free(&file->logical);
    file->logical = row;
}

static void xml_lies(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
        stp_status status;
        const char *text;
    } lies[] = {
        {"<e57Root", "<e57Rood", STP_CORRUPT, "the root is `e57Rood`"},
        {"</data3D>", "</data4D>", STP_CORRUPT, "mismatched tag"},
        {"UTF-8", "EBCDIC-X", STP_CORRUPT, "encoding"},
        {"<?xml version=\"1.0\" encoding=\"UTF-8\"?>", "<?xml version=\"1.0\"?><!DOCTYPE e57Root>",
         STP_CORRUPT, "document type"},
        {"fileOffset=\"48\"", "", STP_CORRUPT, "fileOffset"},
        {"fileOffset=\"48\"", "fileOffset=\"-48\"", STP_CORRUPT, "fileOffset"},
        {"fileOffset=\"48\"", "fileOffset=\"1020\"", STP_CORRUPT, "inside a page's checksum"},
        {"fileOffset=\"48\"", "fileOffset=\"0\"", STP_CORRUPT, "a section of kind 65"},
        {"fileOffset=\"48\"", "fileOffset=\"18446744073709551615\"", STP_CORRUPT,
         "18446744073709551615"},
        {"recordCount=\"200\"", "recordCount=\"\"", STP_CORRUPT, "recordCount"},
        {"recordCount=\"200\"", "recordCount=\"201\"", STP_CORRUPT, "200 of its 201"},
        {"recordCount=\"200\"", "recordCount=\"190\"", STP_CORRUPT, "more than the 190"},
        {"recordCount=\"200\"", "recordCount=\"199\"", STP_CORRUPT, "more than the 199"},
        {"recordCount=\"200\"", "recordCount=\"20000\"", STP_CORRUPT, "hold at most"},
        {"recordCount=\"200\"", "recordCount=\"18446744073709551615\"", STP_CORRUPT,
         "hold at most"},
        {"cartesianZ", "cartesianW", STP_CORRUPT, "neither all of cartesianX"},
        {"cartesianZ", "cartesianX", STP_CORRUPT, "`cartesianX` stands there twice"},
        {"precision=\"single\"", "precision=\"half\"", STP_CORRUPT, "precision"},
        {"precision=\"single\"", "precision=\"double\"", STP_CORRUPT, "hold at most"},
        {"type=\"Float\" precision=\"single\"", "type=\"Blob\"", STP_CORRUPT, "has a type"},
        {"type=\"Float\" precision=\"single\"", "", STP_CORRUPT, "has a type"},
        {"type=\"Float\" precision=\"single\"", "type=\"String\"", STP_CORRUPT, "has a type"},
        {"maximum=\"4095\"", "maximum=\"-1\"", STP_CORRUPT, "below its minimum"},
        {"maximum=\"4095\"", "maximum=\"many\"", STP_CORRUPT, "no whole number"},
        {"maximum=\"4095\"", "maximum=\"9223372036854775808\"", STP_CORRUPT, "no whole number"},
        {"maximum=\"4095\"", "maximum=\"8191\"", STP_CORRUPT, "of its 200"},
        {"type=\"Integer\" minimum=\"0\"", "type=\"ScaledInteger\" scale=\"0\" minimum=\"0\"",
         STP_CORRUPT, "scale"},
        {"type=\"Integer\" minimum=\"0\"", "type=\"ScaledInteger\" scale=\"nan\" minimum=\"0\"",
         STP_CORRUPT, "scale"},
        {">1</w>", ">0</w>", STP_CORRUPT, "which is no rotation"},
        {">1</w>", ">inf</w>", STP_CORRUPT, "not finite"},
        {">1</w>", ">one</w>", STP_CORRUPT, "`one` is not a number"},
        {">1</w>", ">1e999</w>", STP_CORRUPT, "not finite"},
        {"</prototype>", "</prototype></points><points>", STP_CORRUPT, "two elements `points`"},
        {"<prototype type=\"Structure\">\n",
         "<prototype type=\"Structure\"><name type=\"String\"/>", STP_CORRUPT,
         "not as many bytestreams"},
    };
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        e57_file file = sound_file();
        replace_xml(&file, lies[i].from, lies[i].to);
        e57_write("bad.e57", &file);
        scan_fixture_fails("bad.e57", NULL, lies[i].status, lies[i].text);
        e57_free(&file);
    }
}

/* If all fields are constant, nothing in the file bounds the count. */
static void endless_points(void **state)
{
    (void)state;
    e57_file file;
    e57_begin(&file);
    e57_vector(&file, NULL, 0, true);
    e57_scan(&file, "", 1000000000000u,
             E57_INTEGER("cartesianX", "1", "1") E57_INTEGER("cartesianY", "1", "1")
                 E57_INTEGER("cartesianZ", "1", "1"));
    e57_end(&file, "");
    e57_write("bad.e57", &file);
    scan_fixture_fails("bad.e57", NULL, STP_LIMIT, "1000000000000 points that are all the same");
    replace_xml(&file, "recordCount=\"1000000000000\"", "recordCount=\"1\"");
    e57_write("bad.e57", &file);
    stp_scan_info info;
    stp_point *p = scan_fixture_read("bad.e57", NULL, &info);
    scan_fixture_position(p, 1, 1, 1);
    free(p);
    e57_free(&file);
}

/* Many scans share the same bytes: more points than the file can hold. */
static void shared_points(void **state)
{
    (void)state;
    e57_file file;
    e57_stream s[3] = {0};
    for (unsigned i = 0; i < POINTS; i++)
        for (int axis = 0; axis < 3; axis++)
            bytes_double(&s[axis].bytes, i);
    e57_begin(&file);
    e57_vector(&file, s, 3, false);
    for (int scan = 0; scan < 100; scan++)
        e57_scan(&file, "", POINTS,
                 E57_FLOAT("cartesianX", "double") E57_FLOAT("cartesianY", "double")
                     E57_FLOAT("cartesianZ", "double"));
    e57_end(&file, "");
    e57_write("bad.e57", &file);
    scan_fixture_fails("bad.e57", NULL, STP_CORRUPT, "more points than the file holds");
    e57_free(&file);
    for (int axis = 0; axis < 3; axis++)
        bytes_free(&s[axis].bytes);
}

/* An error in the second scan must be reported before any point of the first is read. */
static void bad_second_scan(void **state)
{
    (void)state;
    e57_file file = sound_file();
    stp_scan *scan = NULL;
    stp_error err = {0};
    replace_xml(&file, "</data3D>",
                "<vectorChild type=\"Structure\"><points fileOffset=\"80\" recordCount=\"1\">"
                "<prototype>" XYZ "</prototype></points></vectorChild></data3D>");
    e57_write("bad.e57", &file);
    assert_int_equal(stp_scan_open(&scan, "bad.e57", NULL, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "byte 80: a section of"));
    assert_null(scan);
    e57_free(&file);
}

/* XML that ends early, at every byte. */
static void cut_xml(void **state)
{
    (void)state;
    e57_file whole = sound_file();
    const uint64_t end = whole.xml.size - strlen("\n");
    for (uint64_t size = 0; size < end; size++) {
        bytes_set(&whole.logical, 32, size, 8);
        e57_write("bad.e57", &whole);
        scan_fixture_fails("bad.e57", NULL, STP_CORRUPT, "XML section, line");
    }
    e57_free(&whole);
}

#define TEN "xxxxxxxxxx"

static byte_row repeated(const char *before, const char *text, size_t count, const char *after)
{
    byte_row row = {0};
    bytes_text(&row, before);
    for (size_t i = 0; i < count; i++)
        bytes_text(&row, text);
    bytes_text(&row, after);
    bytes_add(&row, "", 1);
    return row;
}

static void check_hostile(const char *from, byte_row to, stp_status status, const char *text)
{
    e57_file file = sound_file();
    replace_xml(&file, from, (const char *)to.data);
    e57_write("bad.e57", &file);
    scan_fixture_fails("bad.e57", NULL, status, text);
    bytes_free(&to);
    e57_free(&file);
}

static void hostile_xml(void **state)
{
    (void)state;
    static const char bomb[] =
        "<!DOCTYPE e57Root [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;&a;\">"
        "<!ENTITY c SYSTEM \"file:///etc/passwd\">]>\n<e57Root version=\"&b;&c;\"";
    check_hostile("<e57Root", repeated(bomb, "", 0, ""), STP_CORRUPT, "document type");
    check_hostile("</data3D>", repeated("", "<a>", 100, "</data3D>"), STP_LIMIT,
                  "more than 64 levels");
    check_hostile("</e57Root>", repeated("", "<a/>", 1100000, "</e57Root>"), STP_LIMIT,
                  "tags and attributes");
    check_hostile("</data3D>", repeated("", "<vectorChild/>", 70000, "</data3D>"), STP_LIMIT,
                  "more than 65535 scans");
    check_hostile("</data3D>", repeated("<!-- ", "", 0, "</data3D>"), STP_CORRUPT, "XML section");
    check_hostile("</data3D>", repeated("<a b=\"", TEN, 200000, "\"/></data3D>"), STP_LIMIT,
                  "a tag or comment of more than");
    check_hostile("</data3D>", repeated("<!--", TEN, 200000, "--></data3D>"), STP_LIMIT,
                  "a tag or comment of more than");
    check_hostile(">1</w>", repeated("0", "", 0, "1</w>"), STP_CORRUPT, "not well-formed");
    check_hostile(">1</w>", repeated(">", "1", 200, "</w>"), STP_CORRUPT, "a number has more than");
    check_hostile("</data3D>",
                  repeated("</data3D><coordinateMetadata>", TEN, 150000, "</coordinateMetadata>"),
                  STP_LIMIT, "coordinateMetadata is longer");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_file_is_sound), cmocka_unit_test(bad_pages),
        cmocka_unit_test(cut_files),         cmocka_unit_test(header_lies),
        cmocka_unit_test(section_lies),      cmocka_unit_test(packet_lies),
        cmocka_unit_test(cut_sections),      cmocka_unit_test(xml_lies),
        cmocka_unit_test(endless_points),    cmocka_unit_test(shared_points),
        cmocka_unit_test(bad_second_scan),   cmocka_unit_test(cut_xml),
        cmocka_unit_test(hostile_xml),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
