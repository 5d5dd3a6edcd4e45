/* An attribute of points beside position, colour, intensity and class: its name, its type, and how
 * to read its numbers. GPS time and return number are attributes, for example.
 *
 * A stored number is a word of 64 bits: integers keep their value (sign-extended), floats their
 * bits. Packed, a number has as many bytes as its type, little-endian. Threads: any (pure
 * functions). */
#ifndef STP_FORMATS_ATTRIBUTE_ATTRIBUTE_H
#define STP_FORMATS_ATTRIBUTE_ATTRIBUTE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* X(name, text, bytes) */
#define STP_ATTRIBUTE_TYPE_LIST(X)                                                                 \
    X(U8, "u8", 1)                                                                                 \
    X(I8, "i8", 1)                                                                                 \
    X(U16, "u16", 2)                                                                               \
    X(I16, "i16", 2)                                                                               \
    X(U32, "u32", 4)                                                                               \
    X(I32, "i32", 4)                                                                               \
    X(U64, "u64", 8)                                                                               \
    X(I64, "i64", 8)                                                                               \
    X(F32, "f32", 4)                                                                               \
    X(F64, "f64", 8)

typedef enum stp_attribute_type {
#define X(name, text, bytes) STP_ATTRIBUTE_##name,
    STP_ATTRIBUTE_TYPE_LIST(X)
#undef X
        STP_ATTRIBUTE_TYPE_COUNT
} stp_attribute_type;

/* Most attributes of a scan or a model. */
#define STP_ATTRIBUTES_LIMIT 64u
#define STP_ATTRIBUTE_NAME_BYTES 48u

/* What a sample holds in 8 bits of an attribute that has more. */
typedef enum stp_attribute_coarse {
    STP_COARSE_NOT,
    STP_COARSE_RED,
    STP_COARSE_GREEN,
    STP_COARSE_BLUE,
    STP_COARSE_INTENSITY
} stp_attribute_coarse;

typedef struct stp_attribute {
    char name[STP_ATTRIBUTE_NAME_BYTES]; /* ASCII, no control characters; unique in its list */
    stp_attribute_type type;
    double scale, offset; /* value = number * scale + offset */
    bool has_missing;     /* some points have no value: floats are NaN then, and integers: */
    int64_t missing;
    /* Colours and intensities: the sample's 8 bits times coarse_scale, rounded, are near the
     * number. derived: at level 0 they are the number, so none is stored. */
    stp_attribute_coarse coarse;
    double coarse_scale;
    bool derived;
} stp_attribute;

/* Attributes in their order. */
typedef struct stp_attribute_list {
    stp_attribute items[STP_ATTRIBUTES_LIMIT];
    uint32_t count;
} stp_attribute_list;

/* "u8", ... */
const char *stp_attribute_type_name(stp_attribute_type type);
/* STP_ATTRIBUTE_TYPE_COUNT if there is no such type. */
stp_attribute_type stp_attribute_type_from(const char *name);
/* Bytes of a packed number. */
size_t stp_attribute_bytes(stp_attribute_type type);
static inline bool stp_attribute_is_float(stp_attribute_type type)
{
    return type == STP_ATTRIBUTE_F32 || type == STP_ATTRIBUTE_F64;
}
/* Bytes of a packed point: of all attributes, one after the other. */
size_t stp_attribute_list_bytes(const stp_attribute_list *list);
/* The index of a name, or UINT32_MAX. */
uint32_t stp_attribute_find(const stp_attribute_list *list, const char *name);
/* The attribute that somebody means who types `words`: of this name; else the only one whose name
 * begins so; else the only one whose name has it. - stands for _. UINT32_MAX: none, or several. */
uint32_t stp_attribute_match(const stp_attribute_list *list, const char *words);

/* Packs and unpacks a number. Packing drops the bits that the type does not have. */
void stp_attribute_put(stp_attribute_type type, uint64_t word, uint8_t *bytes);
uint64_t stp_attribute_get(stp_attribute_type type, const uint8_t *bytes);

/* The word that stands for no value. */
uint64_t stp_attribute_missing(const stp_attribute *attribute);
/* The value of a word: NaN if it is missing. */
double stp_attribute_value(const stp_attribute *attribute, uint64_t word);
/* The word of another type for the same number; a float loses its fraction in an integer. */
uint64_t stp_attribute_convert(stp_attribute_type from, uint64_t word, stp_attribute_type to);
/* The least type that holds all numbers of both and, if `missing`, one more. F64 if there is none;
 * then integers beyond 2^53 are rounded. */
stp_attribute_type stp_attribute_join(stp_attribute_type a, stp_attribute_type b, bool missing);
/* A number of the type that no number of `narrower` is; used as missing. */
int64_t stp_attribute_spare(stp_attribute_type type);

#endif
