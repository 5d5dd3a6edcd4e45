/* Tests colours by attribute: a picture by intensity or class must equal the picture of the same
 * points with the palette's colours. Elevation: test_gl_elevation. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"

#define COUNT 20000u
#define SIZE 200

static const stp_dvec3 centre = {500000.0, 4.5e6, 300.0};
static const double radius = 20.0;

/* Palettes written again from the description in shaders/shade/palette.glsl. */
static void grey(double x, double rgb[3])
{
    rgb[0] = rgb[1] = rgb[2] = x;
}

static void viridis(double x, double rgb[3])
{
    static const double at[5][3] = {{0.267, 0.005, 0.329},
                                    {0.229, 0.322, 0.546},
                                    {0.128, 0.567, 0.551},
                                    {0.369, 0.789, 0.383},
                                    {0.993, 0.906, 0.144}};
    int part = x >= 1.0 ? 3 : (int)(4.0 * x);
    for (int c = 0; c < 3; c++)
        rgb[c] = at[part][c] + (at[part + 1][c] - at[part][c]) * (4.0 * x - part);
}

/* Ground, high vegetation, building, water. */
static const uint8_t classes[4] = {2, 5, 6, 9};
static const double class_colours[4][3] = {
    {0.60, 0.43, 0.25}, {0.10, 0.45, 0.15}, {0.85, 0.35, 0.25}, {0.20, 0.45, 0.90}};

static double clamped(double x)
{
    return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

/* The colour of a point of the cloud under these parameters. */
static void expected(const stp_point *p, const stp_draw_params *params, double rgb[3])
{
    double low = params->colour_range[0], extent = params->colour_range[1] - low;
    if (params->colour == STP_COLOUR_CLASS) {
        for (int k = 0; k < 4; k++)
            if (p->class_id == classes[k])
                memcpy(rgb, class_colours[k], 3 * sizeof *rgb);
    } else {
        double x = clamped(((p->intensity >> 8) / 255.0 - low) / extent);
        (params->palette == STP_PALETTE_VIRIDIS ? viridis : grey)(x, rgb);
    }
}

static prep_cloud make_cloud(void)
{
    prep_cloud cloud = prep_cloud_wavy(COUNT, centre, radius);
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].class_id = classes[i % 4];
    return cloud;
}

static uint8_t *draw(prep_cloud *cloud, const char *path, const stp_draw_params *params)
{
    gl_fixture f = {0};
    stp_prep_stats stats;
    stp_view view;
    uint8_t *picture = malloc(SIZE * SIZE * 4);
    assert_non_null(picture);
    const stp_prep_params marks = {
        .outliers = params->colour == STP_COLOUR_OUTLIERS ? STP_OUTLIERS_MARK : STP_OUTLIERS_KEEP};
    check_ok(prep_cloud_run(cloud, path, 2, &marks, &stats, err));
    gl_fixture_open(&f, path, NULL);
    stp_camera camera = stp_camera_default(&f.model->info->box, &f.model->ball, SIZE, SIZE);
    check_ok(stp_view_create(&view, &camera, &f.model->ball, SIZE, SIZE, err));
    check_ok(stp_renderer_draw(f.renderer, &view, params, NULL, err));
    check_ok(stp_renderer_read(f.renderer, picture, err));
    gl_fixture_close(&f);
    return picture;
}

/* Draws by attribute, then draws the same points with the palette's colours. */
static void check_colours(stp_draw_params params)
{
    prep_cloud cloud = make_cloud();
    params.every_sample = true;
    params.shade = STP_SHADE_LAMBERT;
    uint8_t *by_attribute = draw(&cloud, "colours_a.stipple", &params);
    for (uint32_t i = 0; i < COUNT; i++) {
        double rgb[3] = {0.0};
        expected(&cloud.points[i], &params, rgb);
        for (int c = 0; c < 3; c++)
            cloud.points[i].rgb[c] = (uint16_t)(65535.0 * rgb[c] + 0.5);
    }
    params.colour = STP_COLOUR_RGB;
    uint8_t *by_colour = draw(&cloud, "colours_b.stipple", &params);
    unsigned covered = 0, differing = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        assert_int_equal(by_attribute[4 * i + 3], by_colour[4 * i + 3]);
        covered += by_colour[4 * i + 3] != 0;
        for (size_t c = 0; c < 3; c++)
            if (abs(by_attribute[4 * i + c] - by_colour[4 * i + c]) > 2) /* rounded twice */
                differing++;
    }
    assert_true(covered > SIZE * SIZE / 5);
    assert_int_equal(differing, 0);
    free(by_attribute);
    free(by_colour);
    free(cloud.points);
}

static void by_intensity(void **state)
{
    (void)state;
    check_colours((stp_draw_params){.colour = STP_COLOUR_INTENSITY, .colour_range = {0.0, 1.0}});
    check_colours((stp_draw_params){.colour = STP_COLOUR_INTENSITY,
                                    .palette = STP_PALETTE_VIRIDIS,
                                    .colour_range = {0.25, 0.5},
                                    .lod = STP_LOD_COMPUTE});
}

static void by_class(void **state)
{
    (void)state;
    check_colours((stp_draw_params){.colour = STP_COLOUR_CLASS});
}

/* Marked points must be magenta, the others grey by their brightness. Draws single pixels. */
static void by_outliers(void **state)
{
    (void)state;
    enum { FAR = 12 };
    prep_cloud cloud = make_cloud();
    stp_draw_params params = {.colour = STP_COLOUR_OUTLIERS,
                              .reconstruct = STP_RECONSTRUCT_POINTS,
                              .shade = STP_SHADE_LAMBERT,
                              .every_sample = true};
    for (uint32_t i = 0; i < COUNT; i++)
        for (int c = 0; c < 3; c++)
            cloud.points[i].rgb[c] = c == 1 ? 65535 : 0; /* green, not grey */
    for (uint32_t i = 0; i < FAR; i++)
        cloud.points[i].position =
            (stp_dvec3){centre.x + 2.0 * radius * cos(0.5 * i),
                        centre.y + 2.0 * radius * sin(0.5 * i), centre.z + 5.0 * i - 25.0};
    uint8_t *picture = draw(&cloud, "colours_a.stipple", &params);
    unsigned magenta = 0, grey_count = 0, other = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        const uint8_t *p = picture + 4 * i;
        if (p[3] == 0)
            continue;
        bool grey_pixel = p[0] == p[1] && p[1] == p[2];
        bool magenta_pixel = p[0] > p[2] && p[2] > 2 * p[1];
        grey_count += grey_pixel;
        magenta += magenta_pixel;
        other += !grey_pixel && !magenta_pixel;
    }
    assert_int_equal(other, 0);
    assert_true(magenta >= FAR / 3 && magenta <= FAR);
    assert_true(grey_count > 1000);
    free(picture);
    free(cloud.points);
}

/* Finds the share of the pixels of each fit: nearest, wide, widest, given. All pixels must have one
 * of these four colours. */
static void shares_by_fit(prep_cloud *cloud, double shares[4])
{
    static const uint8_t colours[4][3] = {
        {77, 179, 89}, {242, 204, 64}, {230, 77, 51}, {77, 128, 230}};
    const stp_draw_params params = {.colour = STP_COLOUR_FIT,
                                    .reconstruct = STP_RECONSTRUCT_POINTS,
                                    .shade = STP_SHADE_UNLIT,
                                    .every_sample = true};
    uint8_t *picture = draw(cloud, "colours_a.stipple", &params);
    unsigned counts[4] = {0}, covered = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++) {
        covered += picture[4 * i + 3] != 0;
        for (int fit = 0; fit < 4; fit++)
            counts[fit] += picture[4 * i + 3] != 0 && abs(picture[4 * i] - colours[fit][0]) <= 1 &&
                           abs(picture[4 * i + 1] - colours[fit][1]) <= 1 &&
                           abs(picture[4 * i + 2] - colours[fit][2]) <= 1;
    }
    assert_true(covered > 1000);
    assert_int_equal(counts[0] + counts[1] + counts[2] + counts[3], covered);
    for (int fit = 0; fit < 4; fit++)
        shares[fit] = (double)counts[fit] / covered;
    free(picture);
}

/* With more noise, planes are wider. If the input has normals, nothing is fitted. */
static void by_fit(void **state)
{
    (void)state;
    const double spacing = sqrt(4.0 * M_PI * radius * radius / COUNT);
    double shares[4];
    prep_cloud cloud = make_cloud();
    shares_by_fit(&cloud, shares);
    assert_true(shares[0] > 0.9);
    for (uint32_t i = 0; i < COUNT; i++) {
        const stp_dvec3 out = stp_dvec3_normalize(stp_dvec3_sub(cloud.points[i].position, centre));
        const double off = spacing * (stp_random_unit(7, i) + stp_random_unit(8, i) - 1.0);
        cloud.points[i].position =
            stp_dvec3_add(cloud.points[i].position, stp_dvec3_scale(out, 2.0 * off));
    }
    shares_by_fit(&cloud, shares);
    assert_true(shares[1] + shares[2] > 0.9 && shares[2] > 0.5);
    for (uint32_t i = 0; i < COUNT; i++)
        cloud.points[i].normal = stp_dvec3_to_float(
            stp_dvec3_normalize(stp_dvec3_sub(cloud.points[i].position, centre)));
    shares_by_fit(&cloud, shares);
    assert_true(shares[3] == 1.0);
    free(cloud.points);
}

/* Intensities spread evenly; heights go from end to end. */
static void ranges(void **state)
{
    (void)state;
    stp_prep_stats stats;
    stp_model *model = NULL;
    double range[2];
    prep_cloud cloud = make_cloud();
    check_ok(prep_cloud_run(&cloud, "colours_a.stipple", 2, NULL, &stats, err));
    check_ok(stp_model_open(&model, "colours_a.stipple", err));
    check_ok(stp_model_colour_range(model, STP_COLOUR_INTENSITY, range, err));
    assert_true(fabs(range[0] - 0.02) < 0.01 && fabs(range[1] - 0.98) < 0.01);
    check_ok(stp_model_colour_range(model, STP_COLOUR_ELEVATION, range, err));
    assert_true(range[0] < centre.z - 0.9 * radius && range[0] > centre.z - radius);
    assert_true(range[1] > centre.z + 0.9 * radius && range[1] < centre.z + radius);
    stp_model_close(&model);
    free(cloud.points);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(by_intensity), cmocka_unit_test(by_class), cmocka_unit_test(by_outliers),
        cmocka_unit_test(by_fit),       cmocka_unit_test(ranges),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    stp_gl_context_destroy(&context);
    return failed;
}
