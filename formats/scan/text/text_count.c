/* Reads lines that say how many lines follow. */
#include "formats/scan/text/text_count.h"

#include "formats/scan/number.h"

static void trim(const char **begin, const char **end)
{
    while (*begin < *end && stp_is_blank(**begin))
        ++*begin;
    while (*end > *begin && stp_is_blank((*end)[-1]))
        --*end;
}

bool stp_text_is_count(const char *begin, const char *end)
{
    trim(&begin, &end);
    const char *at = begin;
    while (at < end && *at >= '0' && *at <= '9')
        at++;
    return at == end && begin < end;
}

stp_status stp_text_next_count(stp_text *text, const char *what, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    STP_TRY(stp_text_next(text, &begin, &end, err));
    if (!begin) {
        *count = STP_TEXT_NO_COUNT;
        return STP_OK;
    }
    trim(&begin, &end);
    uint64_t value;
    if (!stp_number_parse_u64(begin, end, &value) || value == STP_TEXT_NO_COUNT)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu: expected %s or the end of the file, found `%.*s`: the "
                             "numbers of lines are wrong; mend them or export the file again",
                             text->source.path, (unsigned long long)text->source.line, what,
                             end - begin < 40 ? (int)(end - begin) : 40, begin);
    *count = value;
done:
    return status;
}

stp_status stp_text_few_lines(const stp_text *text, uint64_t count_line, uint64_t count,
                              uint64_t found, stp_error *err)
{
    const bool ends = text->source.offset >= text->source.size;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu declares %llu points, but %llu follow until %s line %llu: "
                         "the file was cut or the number is wrong; copy or export it again",
                         text->source.path, (unsigned long long)count_line,
                         (unsigned long long)count, (unsigned long long)found,
                         ends ? "the end at" : "the next number at",
                         (unsigned long long)text->source.line);
}
