/* Reads numbers of grids. */
#include "formats/scan/grid/raster_numbers.h"

#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/number.h"
#include "formats/scan/text/text_line.h"

#include <math.h>
#include <string.h>

bool stp_raster_text_number(const char *begin, const char *end, double *number)
{
    return stp_number_parse(begin, end, number) ||
           stp_field_number(STP_SEPARATOR_TAB, (stp_field){begin, end}, number);
}

stp_status stp_raster_text_read(stp_raster_text *t, uint32_t row, double *numbers, uint32_t count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < count;) {
        const char *begin = t->at != NULL ? stp_token(&t->at, t->end) : NULL;
        if (begin == NULL) {
            STP_TRY(stp_source_line(&t->source, &t->at, &t->end, err));
            if (t->at == NULL)
                return stp_error_set(err, STP_CORRUPT, "%s ends in row %u: copy or export it again",
                                     t->source.path, row + 1);
            continue;
        }
        if (!stp_raster_text_number(begin, t->at, &numbers[i++]))
            return stp_error_set(
                err, STP_CORRUPT,
                "%s: line %llu: `%.*s` is no number: mend it, or export the file again",
                t->source.path, (unsigned long long)t->source.line,
                (int)(t->at - begin < 40 ? t->at - begin : 40), begin);
    }
done:
    return status;
}

bool stp_raster_is_side(double number)
{
    return number >= 1.0 && number <= STP_RASTER_SIDE_LIMIT && number == floor(number);
}

double stp_raster_float(const unsigned char bytes[4], bool little)
{
    uint32_t bits = 0;
    float value;
    for (unsigned i = 0; i < 4; i++)
        bits = bits << 8 | bytes[little ? 3 - i : i];
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}
