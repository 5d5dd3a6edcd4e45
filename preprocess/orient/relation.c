/* Relates two points' normals. */
#include "preprocess/orient/relation.h"

#define SHEET_COSINE 0.7f
#define SHEET_OFFSET 0.5f /* in spacings, from each other's plane */
#define CRUMB_OFFSET 1.0f /* at this offset a point may be noise, or on another sheet */

static float greater(float a, float b)
{
    return a > b ? a : b;
}

/* On a smooth piece the normals' signs compare directly. Across a crease, one normal is reflected
 * in the plane between the two points and then compared. The nearer the reflected normal is to a
 * right angle with the other, the less the relation says. */
stp_relation stp_relate(const stp_cloud_point *p, const stp_cloud_point *q)
{
    if (!stp_has_normal(p) || !stp_has_normal(q))
        return (stp_relation){.rank = STP_RANK_NONE};
    vec3s d = stp_dvec3_to_float(stp_dvec3_sub(q->position, p->position));
    float cosine = glms_vec3_dot(p->normal, q->normal);
    float along_p = glms_vec3_dot(p->normal, d), along_q = glms_vec3_dot(q->normal, d);
    float scale = greater(p->spacing, q->spacing);
    float offset = greater(fabsf(along_p), fabsf(along_q)) / scale;
    bool parallel = fabsf(cosine) > SHEET_COSINE;
    if (parallel && offset <= SHEET_OFFSET) {
        float badness =
            greater((1.0f - fabsf(cosine)) / (1.0f - SHEET_COSINE), offset / SHEET_OFFSET);
        return (stp_relation){.rank = (uint16_t)(badness * (float)(STP_RANK_SMOOTH - 1)),
                              .turned = cosine < 0.0f,
                              .height_p = along_p,
                              .height_q = -along_q};
    }
    if (parallel && offset > CRUMB_OFFSET) /* too far apart to relate */
        return (stp_relation){.rank = STP_RANK_NONE};
    float reflected = cosine - 2.0f * along_p * along_q / glms_vec3_norm2(d);
    float badness = greater(1.0f - fabsf(reflected), 0.0f); /* NaN (floats overflowed) becomes 0 */
    return (stp_relation){
        .rank = (uint16_t)(STP_RANK_SMOOTH +
                           (uint32_t)(badness * (float)(STP_RANK_NONE - STP_RANK_SMOOTH - 1))),
        .turned = reflected < 0.0f,
        .narrow = parallel};
}

stp_relation stp_relate_marked(const stp_cloud *cloud, uint64_t a, uint64_t b)
{
    stp_relation r = stp_relate(&cloud->points[a], &cloud->points[b]);
    r.turned ^= ((cloud->marks[a] ^ cloud->marks[b]) & STP_MARK_TURNED) != 0;
    return r;
}

/* Measured on the statue, 300 k points with noise of 0.1 spacings. */
float stp_relation_odds(stp_relation r)
{
    float odds = 6.0f;
    if (r.rank >= STP_RANK_SMOOTH)
        odds = 4.2f -
               3.8f * (float)(r.rank - STP_RANK_SMOOTH) / (float)(STP_RANK_NONE - STP_RANK_SMOOTH);
    else if (r.rank >= STP_RANK_SURE)
        odds = 5.0f;
    return r.turned ? -odds : odds;
}
