/* Reads a PLY file as a mesh: all vertices, its polygons or triangle strips as triangles, and its
 * edges. */
#include "formats/scan/ply/ply.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Turns lists of vertex numbers into triangles. */
typedef struct face_builder {
    stp_point_mesh *mesh;
    const stp_ply *ply;
    bool strips;          /* false: each list is a fan */
    uint64_t corner;      /* number of the corner in the polygon or strip */
    uint32_t first, last; /* fan: first and last corner; strip: the last two corners */
} face_builder;

static stp_status bad_index(const face_builder *b, double index, stp_error *err)
{
    const stp_ply_cursor *c = &b->ply->cursor;
    const bool ascii = c->encoding == STP_PLY_ASCII;
    return stp_error_set(
        err, STP_CORRUPT,
        "%s: %s %llu: %s %llu names vertex %.17g, but there are %llu (counted from "
        "0): mend the mesh or export it again",
        c->source->path, ascii ? "line" : "byte",
        (unsigned long long)(ascii ? c->source->line : c->source->offset), c->element->name,
        (unsigned long long)c->index, index, (unsigned long long)b->ply->vertex->count);
}

static stp_status add_corner(face_builder *b, double value, stp_error *err)
{
    stp_status status = STP_OK;
    if (b->strips && value == -1.0) { /* a new strip begins */
        b->corner = 0;
        return STP_OK;
    }
    if (!(value >= 0.0 && value < (double)b->ply->vertex->count && value <= (double)UINT32_MAX &&
          value == (double)(uint64_t)value))
        return bad_index(b, value, err);
    const uint32_t index = (uint32_t)value;
    if (b->corner >= 2) {
        /* Every second triangle of a strip has the opposite winding. */
        const bool flip = b->strips && b->corner % 2 == 1;
        STP_TRY(stp_point_mesh_add_triangle(b->mesh, flip ? b->last : b->first,
                                            flip ? b->first : b->last, index, err));
    }
    if (b->corner == 0)
        b->first = index;
    else if (b->strips && b->corner >= 2)
        b->first = b->last;
    if (b->corner > 0 || !b->strips)
        b->last = index;
    b->corner++;
done:
    return status;
}

static stp_status read_index_list(stp_ply *ply, const stp_ply_property *list, face_builder *builder,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t length;
    double index;
    STP_TRY(stp_ply_next_length(&ply->cursor, list, &length, err));
    builder->corner = 0;
    for (uint64_t i = 0; i < length; i++) {
        STP_TRY(stp_ply_next_value(&ply->cursor, list->type, &index, err));
        STP_TRY(add_corner(builder, index, err));
    }
done:
    return status;
}

/* The places of a face's corners in an image: the properties texcoord, u and v of each corner, and
 * texnumber, the image. */
typedef struct place_reader {
    const stp_ply_property *list, *number; /* NULL: there are none */
    float (*uv)[2];
    size_t count, capacity;
    uint32_t image;
} place_reader;

/* The same by vertex, if faces tell none: images' places that the properties s and t of vertices
 * have, for all faces in the first image. */
typedef struct vertex_places {
    float (*uv)[2];
    size_t count, capacity;
} vertex_places;

static stp_status keep_vertex_places(const stp_ply *ply, vertex_places *places, size_t count,
                                     stp_error *err)
{
    stp_status status = STP_OK;
    if (!stp_ply_target_property(ply, STP_PLY_S) || !stp_ply_target_property(ply, STP_PLY_T))
        return STP_OK;
    STP_TRY(stp_grow(&places->uv, &places->capacity, places->count + count, sizeof *places->uv,
                     "texture coordinates", err));
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 2; c++)
            places->uv[places->count + i][c] =
                stp_texture_place(ply->columns[c == 0 ? STP_PLY_S : STP_PLY_T][i]);
    places->count += count;
done:
    return status;
}

/* Gives triangles from the first one on the places of their vertices. */
static stp_status add_vertex_places(const vertex_places *places, stp_point_mesh *mesh, size_t first,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t t = first; t < mesh->triangle_count; t++) {
        float corners[3][2];
        for (int k = 0; k < 3; k++)
            memcpy(corners[k], places->uv[mesh->triangles[t][k]], sizeof corners[k]);
        STP_TRY(stp_materials_add_triangle(&mesh->materials, 0, (const float(*)[2])corners, err));
    }
done:
    return status;
}

/* The colour of a face or an edge. */
typedef struct colour_reader {
    const stp_ply_property *of[3]; /* red, green, blue; NULL: there is none */
    uint16_t rgb[3];
} colour_reader;

static place_reader find_places(const stp_ply *ply, const stp_ply_element *element, bool images)
{
    place_reader reader = {.number = stp_ply_number_property(&ply->header, element, "texnumber")};
    for (size_t i = 0; i < element->property_count && images; i++) {
        const stp_ply_property *p = &ply->header.properties[element->property_first + i];
        if (p->is_list && strcmp(p->name, "texcoord") == 0)
            reader.list = p;
    }
    return reader;
}

static stp_status read_places(stp_ply *ply, place_reader *reader, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t length;
    double value;
    STP_TRY(stp_ply_next_length(&ply->cursor, reader->list, &length, err));
    STP_TRY(stp_grow(&reader->uv, &reader->capacity, (size_t)length / 2 + 1, sizeof *reader->uv,
                     "texture coordinates", err));
    for (uint64_t i = 0; i < length; i++) {
        STP_TRY(stp_ply_next_value(&ply->cursor, reader->list->type, &value, err));
        reader->uv[i / 2][i % 2] = stp_texture_place(value);
    }
    reader->count = (size_t)length / 2;
done:
    return status;
}

/* Gives the triangles of the face that was read last their places. */
static stp_status add_places(const place_reader *reader, stp_point_mesh *mesh, size_t first,
                             stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t t = first; t < mesh->triangle_count; t++) {
        const size_t corner[3] = {0, t - first + 1, t - first + 2}; /* of the fan */
        float places[3][2];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 2; c++)
                places[k][c] = corner[k] < reader->count ? reader->uv[corner[k]][c] : NAN;
        STP_TRY(stp_materials_add_triangle(&mesh->materials, reader->image,
                                           (const float(*)[2])places, err));
    }
done:
    return status;
}

static stp_status read_image_number(stp_ply *ply, place_reader *reader, size_t images,
                                    stp_error *err)
{
    double value;
    const stp_status status = stp_ply_next_value(&ply->cursor, reader->number->type, &value, err);
    const bool exists = value >= 0.0 && value < (double)images;
    reader->image = status == STP_OK && exists ? (uint32_t)value : STP_NO_MATERIAL;
    return status;
}

/* Scales to 0..65535: bytes by 257, floats as fractions; wider types stay. */
static uint16_t colour_number(double value, stp_ply_type type)
{
    const double scale = type <= STP_PLY_UINT8 ? 257.0 : type >= STP_PLY_FLOAT32 ? 65535.0 : 1.0;
    const double scaled = value * scale;
    return (uint16_t)(scaled > 0.0 ? fmin(scaled, 65535.0) + 0.5 : 0.0);
}

static colour_reader find_colours(const stp_ply *ply, const stp_ply_element *element)
{
    static const char *const names[] = {"red", "green", "blue"};
    colour_reader reader = {.rgb = {0, 0, 0}};
    for (int k = 0; k < 3; k++)
        reader.of[k] = stp_ply_number_property(&ply->header, element, names[k]);
    return reader;
}

static bool are_coloured(const colour_reader *reader)
{
    return reader->of[0] && reader->of[1] && reader->of[2];
}

/* Takes the value of a property that may be one of the colour. */
static void take_channel(colour_reader *reader, const stp_ply_property *p, double value)
{
    for (int k = 0; k < 3; k++)
        if (p == reader->of[k])
            reader->rgb[k] = colour_number(value, p->type);
}

/* Whether the colours of faces are taken: colours of vertices go before. */
static bool are_taken(const stp_ply *ply, const colour_reader *faces)
{
    return are_coloured(faces) && !(ply->attributes & STP_POINT_HAS_COLOUR);
}

bool stp_ply_faces_have_colours(const stp_ply *ply)
{
    if (ply->header.textures.count > 0 || !ply->faces)
        return ply->header.textures.count > 0;
    const colour_reader colour = find_colours(ply, ply->faces);
    return are_taken(ply, &colour) && strcmp(ply->faces->name, "tristrips") != 0;
}

/* Reads a property of a face that is no list of vertices or places. */
static stp_status read_face_number(stp_ply *ply, const stp_ply_property *p, place_reader *places,
                                   colour_reader *colour, size_t images, stp_error *err)
{
    stp_status status = STP_OK;
    double value;
    if (places->list && p == places->number)
        return read_image_number(ply, places, images, err);
    if (p->is_list)
        return stp_ply_skip_property(&ply->cursor, p, err);
    STP_TRY(stp_ply_next_value(&ply->cursor, p->type, &value, err));
    take_channel(colour, p, value);
done:
    return status;
}

static stp_status read_faces(stp_ply *ply, const stp_ply_element *element,
                             const vertex_places *of_vertices, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_cursor *cursor = &ply->cursor;
    const stp_ply_property *list = stp_ply_index_list(&ply->header, element);
    const size_t first_triangle = mesh->triangle_count;
    const size_t images = mesh->materials.count;
    place_reader places = find_places(ply, element, images > 0);
    colour_reader colour = find_colours(ply, element);
    const bool coloured = images == 0 && are_taken(ply, &colour); /* images go before */
    face_builder builder = {
        .mesh = mesh, .ply = ply, .strips = strcmp(element->name, "tristrips") == 0};
    cursor->element = element;
    cursor->index = 0;
    while (cursor->index < element->count) {
        const size_t first = mesh->triangle_count;
        STP_TRY(stp_ply_record_begin(cursor, err));
        for (size_t i = 0; i < element->property_count; i++) {
            const stp_ply_property *p = &ply->header.properties[element->property_first + i];
            STP_TRY(p == list ? read_index_list(ply, p, &builder, err)
                    : places.list && p == places.list
                        ? read_places(ply, &places, err)
                        : read_face_number(ply, p, &places, &colour, images, err));
        }
        STP_TRY(stp_ply_record_end(cursor, err));
        if (places.list && !builder.strips)
            STP_TRY(add_places(&places, mesh, first, err));
        else if (images > 0 && of_vertices->count == ply->vertex->count)
            STP_TRY(add_vertex_places(of_vertices, mesh, first, err));
        else if (coloured && !builder.strips)
            STP_TRY(stp_materials_add_plain(&mesh->materials, colour.rgb,
                                            mesh->triangle_count - first, err));
    }
    mesh->face_count = builder.strips ? mesh->triangle_count - first_triangle : element->count;
done:
    free(places.uv);
    return status;
}

/* The properties of an edge that are read: its ends and its colour. */
typedef struct edge_reader {
    const stp_ply_property *ends[2];
    colour_reader colour;
} edge_reader;

static uint32_t vertex_number(double value)
{
    bool whole = value >= 0.0 && value < (double)STP_MESH_NO_VERTEX && value == floor(value);
    return whole ? (uint32_t)value : STP_MESH_NO_VERTEX;
}

static stp_status read_edge(stp_ply *ply, edge_reader *reader, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_element *element = ply->edges;
    stp_mesh_edge edge = {{STP_MESH_NO_VERTEX, STP_MESH_NO_VERTEX}, {0, 0, 0}};
    double value;
    STP_TRY(stp_ply_record_begin(&ply->cursor, err));
    for (size_t i = 0; i < element->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[element->property_first + i];
        if (p->is_list) {
            STP_TRY(stp_ply_skip_property(&ply->cursor, p, err));
            continue;
        }
        STP_TRY(stp_ply_next_value(&ply->cursor, p->type, &value, err));
        for (int k = 0; k < 2; k++)
            if (p == reader->ends[k])
                edge.vertices[k] = vertex_number(value);
        take_channel(&reader->colour, p, value);
    }
    memcpy(edge.rgb, reader->colour.rgb, sizeof edge.rgb);
    STP_TRY(stp_ply_record_end(&ply->cursor, err));
    STP_TRY(stp_point_mesh_add_edge(mesh, &edge, err));
done:
    return status;
}

static stp_status read_edges(stp_ply *ply, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    static const char *const ends[] = {"vertex1", "vertex2"};
    edge_reader reader = {.colour = find_colours(ply, ply->edges)};
    for (int k = 0; k < 2; k++)
        reader.ends[k] = stp_ply_number_property(&ply->header, ply->edges, ends[k]);
    mesh->edge_colours = are_coloured(&reader.colour);
    ply->cursor.element = ply->edges;
    ply->cursor.index = 0;
    while (ply->cursor.index < ply->edges->count)
        STP_TRY(read_edge(ply, &reader, mesh, err));
done:
    return status;
}

/* Adds the half-widths of the points that were read last. */
static stp_status add_radii(const stp_ply *ply, stp_point_mesh *mesh, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    if (!ply->edges || !stp_ply_target_property(ply, STP_PLY_RADIUS))
        return STP_OK;
    STP_TRY(stp_grow(&mesh->radii, &mesh->radius_capacity, mesh->point_count + count,
                     sizeof *mesh->radii, "mesh vertices", err));
    for (size_t i = 0; i < count; i++)
        mesh->radii[mesh->point_count + i] = (float)ply->columns[STP_PLY_RADIUS][i];
done:
    return status;
}

static stp_status read_vertices(stp_ply *ply, vertex_places *places, stp_point_mesh *mesh,
                                stp_error *err)
{
    stp_status status = STP_OK;
    ply->cursor.element = ply->vertex;
    ply->cursor.index = 0;
    for (;;) {
        size_t count;
        STP_TRY(stp_point_mesh_reserve(mesh, ply->source.path, STP_PLY_BLOCK_POINTS, err));
        STP_TRY(
            stp_ply_read(ply, mesh->points + mesh->point_count, STP_PLY_BLOCK_POINTS, &count, err));
        if (count == 0)
            break;
        STP_TRY(add_radii(ply, mesh, count, err));
        STP_TRY(keep_vertex_places(ply, places, count, err));
        mesh->point_count += count;
    }
done:
    return status;
}

stp_status stp_ply_read_mesh(stp_ply *ply, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    vertex_places places = {0};
    const stp_ply_header *header = &ply->header;
    const stp_ply_element *last = ply->faces && ply->faces > ply->vertex ? ply->faces : ply->vertex;
    last = ply->edges && ply->edges > last ? ply->edges : last;
    mesh->attributes = ply->attributes;
    mesh->materials = ply->header.textures; /* their images, that is */
    ply->header.textures = (stp_materials){0};
    stp_source_seek(&ply->source, header->data_offset, header->header_lines);
    for (const stp_ply_element *e = header->elements; e <= last; e++) {
        if (e == ply->vertex)
            STP_TRY(read_vertices(ply, &places, mesh, err));
        else if (e == ply->faces)
            STP_TRY(read_faces(ply, e, &places, mesh, err));
        else if (e == ply->edges)
            STP_TRY(read_edges(ply, mesh, err));
        else
            STP_TRY(stp_ply_skip_element(&ply->cursor, header, e, err));
    }
done:
    free(places.uv);
    return status;
}
