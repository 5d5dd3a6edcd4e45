/* A building of two storeys with ten rooms each: walls, floors, windows, doors that stand open,
 * furniture. From inside a room most of the building is hidden. Metres, +z up.
 *
 *     y
 *     ^  +----w----+----w----+-- ...     w: windows, in the outer walls
 *     |  |         d         d           d: doors; each room has one to every neighbour of its
 *     |  +----d----+----d----+-- ...        storey, in the middle of the wall
 *     |  |         d         d
 *     |  +----w----+----w----+-- ...     Furniture stands in the corners: a straight way leads
 *     +---------------------------> x    through all doors of a row. */
#include "tools/gen/surface.h"

#include "base/memory.h"
#include "base/random.h"

enum { COLUMNS = 5, ROWS = 2, STOREYS = 2 };

static const double room_m = 5.0, storey_m = 3.0, wall_m = 0.2, slab_m = 0.25;
static const double door_width_m = 1.0, door_height_m = 2.1, leaf_m = 0.04;
static const double window_width_m = 1.8, window_low_m = 0.9, window_high_m = 2.2, bar_m = 0.06;
/* Faces are cut into squares of about this side, so that colours vary within a face. */
static const double square_m = 0.25;

typedef struct builder {
    gen_mesh mesh;
    size_t position_capacity, normal_capacity, colour_capacity, triangle_capacity;
    uint64_t key, counter;
    stp_status status; /* of the first failure */
    stp_error *err;
} builder;

static double draw(builder *b)
{
    return stp_random_unit(b->key, b->counter++);
}

static stp_status make_room(builder *b, size_t vertices, size_t triangles)
{
    stp_status status = STP_OK;
    gen_mesh *m = &b->mesh;
    const size_t v = m->vertex_count + vertices, t = m->triangle_count + triangles;
    STP_TRY(stp_grow(&m->positions, &b->position_capacity, v, sizeof *m->positions, "a building",
                     b->err));
    STP_TRY(
        stp_grow(&m->normals, &b->normal_capacity, v, sizeof *m->normals, "a building", b->err));
    STP_TRY(
        stp_grow(&m->colours, &b->colour_capacity, v, sizeof *m->colours, "a building", b->err));
    STP_TRY(stp_grow(&m->triangles, &b->triangle_capacity, t, sizeof *m->triangles, "a building",
                     b->err));
done:
    return status;
}

static uint32_t squares(double length_m)
{
    double count = ceil(length_m / square_m);
    return count < 1.0 ? 1u : (uint32_t)count;
}

static stp_dvec3 along(stp_dvec3 from, stp_dvec3 way, double part)
{
    return stp_dvec3_add(from, stp_dvec3_scale(way, part));
}

/* Adds a rectangle that is seen from the side of u x v. */
static void add_face(builder *b, stp_dvec3 corner, stp_dvec3 u, stp_dvec3 v, vec3s colour)
{
    const uint32_t across = squares(stp_dvec3_length(u)), up = squares(stp_dvec3_length(v));
    const vec3s normal = stp_dvec3_to_float(stp_dvec3_normalize(stp_dvec3_cross(u, v)));
    gen_mesh *m = &b->mesh;
    const uint32_t first = (uint32_t)m->vertex_count;
    if (b->status == STP_OK)
        b->status = make_room(b, (size_t)(across + 1) * (up + 1), (size_t)2 * across * up);
    if (b->status != STP_OK)
        return;
    for (uint32_t j = 0; j <= up; j++)
        for (uint32_t i = 0; i <= across; i++) {
            const stp_dvec3 p = along(along(corner, u, (double)i / across), v, (double)j / up);
            m->positions[m->vertex_count] = stp_dvec3_to_float(p);
            m->normals[m->vertex_count] = normal;
            m->colours[m->vertex_count++] = glms_vec3_scale(colour, (float)(0.9 + 0.1 * draw(b)));
        }
    for (uint32_t j = 0; j < up; j++)
        for (uint32_t i = 0; i < across; i++) {
            const uint32_t a = first + j * (across + 1) + i, c = a + across + 1;
            const uint32_t pair[2][3] = {{a, a + 1, c + 1}, {a, c + 1, c}};
            for (int k = 0; k < 6; k++)
                m->triangles[m->triangle_count + (size_t)(k / 3)][k % 3] = pair[k / 3][k % 3];
            m->triangle_count += 2;
        }
}

/* Faces of a box, as bits. */
enum { LOW_X = 1, HIGH_X = 2, LOW_Y = 4, HIGH_Y = 8, LOW_Z = 16, HIGH_Z = 32, ALL = 63 };

static void add_box(builder *b, stp_dvec3 low, stp_dvec3 high, int faces, vec3s colour)
{
    const stp_dvec3 x = {high.x - low.x, 0.0, 0.0}, y = {0.0, high.y - low.y, 0.0},
                    z = {0.0, 0.0, high.z - low.z};
    if (faces & LOW_X)
        add_face(b, low, z, y, colour);
    if (faces & HIGH_X)
        add_face(b, along(low, x, 1.0), y, z, colour);
    if (faces & LOW_Y)
        add_face(b, low, x, z, colour);
    if (faces & HIGH_Y)
        add_face(b, along(low, y, 1.0), z, x, colour);
    if (faces & LOW_Z)
        add_face(b, low, y, x, colour);
    if (faces & HIGH_Z)
        add_face(b, along(low, z, 1.0), x, y, colour);
}

/* A wall from `begin`, over `length` along x or along y, with one opening in its middle. */
typedef struct wall {
    stp_dvec3 begin; /* middle of the wall's foot */
    double length, height;
    bool along_y;
    double open_width, open_low, open_high; /* no opening: width 0 */
    vec3s colour;
} wall;

/* Adds a box of the wall: from s to t along the wall, from low to high. */
static void add_part(builder *b, const wall *w, const double span[2], const double heights[2],
                     double thickness, int faces)
{
    const double h = 0.5 * thickness;
    const stp_dvec3 o = w->begin;
    if (w->along_y)
        add_box(b, (stp_dvec3){o.x - h, o.y + span[0], o.z + heights[0]},
                (stp_dvec3){o.x + h, o.y + span[1], o.z + heights[1]}, faces, w->colour);
    else
        add_box(b, (stp_dvec3){o.x + span[0], o.y - h, o.z + heights[0]},
                (stp_dvec3){o.x + span[1], o.y + h, o.z + heights[1]}, faces, w->colour);
}

static void add_wall(builder *b, const wall *w)
{
    const int sides = w->along_y ? LOW_X | HIGH_X : LOW_Y | HIGH_Y;
    const int low_end = w->along_y ? LOW_Y : LOW_X, high_end = w->along_y ? HIGH_Y : HIGH_X;
    const double middle = 0.5 * w->length, half = 0.5 * w->open_width;
    const double open[2] = {middle - half, middle + half}, whole[2] = {0.0, w->height};
    if (w->open_width <= 0.0) {
        add_part(b, w, (double[2]){0.0, w->length}, whole, wall_m, sides);
        return;
    }
    add_part(b, w, (double[2]){0.0, open[0]}, whole, wall_m, sides | high_end);
    add_part(b, w, (double[2]){open[1], w->length}, whole, wall_m, sides | low_end);
    add_part(b, w, open, (double[2]){w->open_high, w->height}, wall_m, sides | LOW_Z);
    if (w->open_low <= 0.0)
        return;
    add_part(b, w, open, (double[2]){0.0, w->open_low}, wall_m, sides | HIGH_Z);
    add_part(b, w, (double[2]){middle - 0.5 * bar_m, middle + 0.5 * bar_m},
             (double[2]){w->open_low, w->open_high}, bar_m, sides | low_end | high_end);
    const double cross = 0.5 * (w->open_low + w->open_high);
    add_part(b, w, open, (double[2]){cross - 0.5 * bar_m, cross + 0.5 * bar_m}, bar_m,
             sides | LOW_Z | HIGH_Z);
}

/* Adds the leaf of a door that stands open, at right angles to its wall. */
static void add_leaf(builder *b, const wall *w)
{
    static const vec3s wood = {{0.45f, 0.30f, 0.18f}};
    const double jamb = 0.5 * w->length + 0.5 * w->open_width, out = 0.5 * wall_m;
    const stp_dvec3 o = w->begin;
    const stp_dvec3 low = w->along_y ? (stp_dvec3){o.x + out, o.y + jamb, o.z}
                                     : (stp_dvec3){o.x + jamb, o.y + out, o.z};
    const stp_dvec3 size = w->along_y ? (stp_dvec3){door_width_m, leaf_m, door_height_m}
                                      : (stp_dvec3){leaf_m, door_width_m, door_height_m};
    add_box(b, low, stp_dvec3_add(low, size), ALL, wood);
}

static vec3s paint_of(builder *b)
{
    return (vec3s){{(float)(0.6 + 0.35 * draw(b)), (float)(0.6 + 0.35 * draw(b)),
                    (float)(0.6 + 0.35 * draw(b))}};
}

/* ---- furniture: stands within 1.5 m x 1.5 m, at the corner `at` ---- */

static const vec3s oak = {{0.62f, 0.45f, 0.27f}};

static void add_block(builder *b, stp_dvec3 at, const double box[6], vec3s colour)
{
    add_box(b, (stp_dvec3){at.x + box[0], at.y + box[1], at.z + box[2]},
            (stp_dvec3){at.x + box[3], at.y + box[4], at.z + box[5]}, ALL, colour);
}

/* A board on four legs. */
static void add_table(builder *b, stp_dvec3 at, double side, double height, vec3s colour)
{
    const double leg = 0.06;
    add_block(b, at, (double[6]){0.0, 0.0, height - 0.04, side, side, height}, colour);
    for (int i = 0; i < 4; i++) {
        const double x = i % 2 ? side - leg : 0.0, y = i / 2 ? side - leg : 0.0;
        add_block(b, at, (double[6]){x, y, 0.0, x + leg, y + leg, height - 0.04}, colour);
    }
}

static void add_shelf(builder *b, stp_dvec3 at, vec3s colour)
{
    for (int i = 0; i < 2; i++)
        add_block(b, at, (double[6]){1.16 * i, 0.0, 0.0, 1.16 * i + 0.04, 0.35, 1.9}, colour);
    for (int i = 0; i < 5; i++) {
        const double z = 0.1 + 0.42 * i;
        add_block(b, at, (double[6]){0.04, 0.0, z, 1.16, 0.35, z + 0.03}, colour);
        for (int k = 0; k < 6 && i < 4; k++) { /* books */
            const double x = 0.08 + 0.17 * k, top = z + 0.2 + 0.15 * draw(b);
            add_block(b, at, (double[6]){x, 0.05, z + 0.03, x + 0.13, 0.3, top}, paint_of(b));
        }
    }
}

static void furnish(builder *b, stp_dvec3 at)
{
    switch ((int)(4.0 * draw(b))) {
    case 0:
        add_table(b, at, 1.2, 0.75, oak);
        add_table(b, (stp_dvec3){at.x + 0.4, at.y + 0.4, at.z}, 0.4, 0.45, paint_of(b));
        break;
    case 1:
        add_block(b, at, (double[6]){0.0, 0.0, 0.0, 1.2, 0.6, 1.9}, oak);
        break;
    case 2:
        add_shelf(b, at, oak);
        break;
    default:
        add_block(b, at, (double[6]){0.0, 0.0, 0.15, 1.4, 0.8, 0.45}, paint_of(b));
        add_block(b, at, (double[6]){0.0, 0.0, 0.45, 1.4, 0.2, 0.9}, paint_of(b));
        break;
    }
}

/* ---- the house ---- */

static void add_storey(builder *b, double floor)
{
    const double height = storey_m - slab_m, inner = room_m - wall_m;
    for (int j = 0; j <= ROWS; j++)
        for (int i = 0; i < COLUMNS; i++) {
            const bool outer = j == 0 || j == ROWS;
            const double more = i == 0 ? 0.5 * wall_m : 0.0;
            const double length = room_m + more + (i == COLUMNS - 1 ? 0.5 * wall_m : 0.0);
            const wall w = {{i * room_m - more, j * room_m, floor},
                            length,
                            height,
                            false,
                            outer ? window_width_m : door_width_m,
                            outer ? window_low_m : 0.0,
                            outer ? window_high_m : door_height_m,
                            paint_of(b)};
            add_wall(b, &w);
            if (!outer)
                add_leaf(b, &w);
        }
    for (int i = 0; i <= COLUMNS; i++)
        for (int j = 0; j < ROWS; j++) {
            const bool outer = i == 0 || i == COLUMNS;
            const wall w = {{i * room_m, j * room_m + 0.5 * wall_m, floor},
                            inner,
                            height,
                            true,
                            outer ? 0.0 : door_width_m,
                            0.0,
                            door_height_m,
                            paint_of(b)};
            add_wall(b, &w);
            if (!outer)
                add_leaf(b, &w);
        }
    for (int k = 0; k < 4 * COLUMNS * ROWS; k++) {
        const int column = k / 4 % COLUMNS, row = k / 4 / COLUMNS;
        const double x = column * room_m + (k % 2 ? room_m - 1.75 : 0.3);
        const double y = row * room_m + (k / 2 % 2 ? room_m - 1.75 : 0.3);
        furnish(b, (stp_dvec3){x, y, floor});
    }
}

static stp_status building_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                                gen_mesh *out, stp_error *err)
{
    static const vec3s stone = {{0.55f, 0.53f, 0.50f}};
    builder b = {.key = stp_random_u64(surface->seed, 12), .err = err};
    const double h = 0.5 * wall_m;
    (void)triangle_count;
    (void)pool;
    for (int k = 0; k <= STOREYS; k++) {
        const double z = k * storey_m;
        add_box(&b, (stp_dvec3){-h, -h, z - slab_m},
                (stp_dvec3){COLUMNS * room_m + h, ROWS * room_m + h, z}, ALL, stone);
        if (k < STOREYS)
            add_storey(&b, z);
    }
    if (b.status == STP_OK)
        *out = b.mesh;
    else
        gen_mesh_clear(&b.mesh);
    return b.status;
}

void gen_building_init(gen_surface *surface)
{
    surface->centre = (stp_dvec3){0.5 * COLUMNS * room_m, 0.5 * ROWS * room_m, storey_m};
    surface->radius = 14.0;
    surface->mesh = building_mesh;
}
