/* Sorts doubles without a call for each comparison: quicksort, with the middle one of three as the
 * border of both parts. */
#include "base/sort.h"

/* Fewer values are sorted by insertion. */
#define FEW 16u
/* After so many divisions of a part, qsort takes over: no order of values takes long. */
#define DEEPEST 64u

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void insert(double *v, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        const double value = v[i];
        size_t at = i;
        for (; at > 0 && v[at - 1] > value; at--)
            v[at] = v[at - 1];
        v[at] = value;
    }
}

static double middle_of(double a, double b, double c)
{
    const double low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

/* Moves values that are less than the border, and some equal to it, before the others. Returns how
 * many: at least one, and not all. */
static size_t divide(double *v, size_t count)
{
    const double border = middle_of(v[0], v[count / 2], v[count - 1]);
    size_t low = 0, high = count - 1;
    for (;; low++, high--) {
        while (v[low] < border)
            low++;
        while (v[high] > border)
            high--;
        if (low >= high)
            break;
        const double was = v[low];
        v[low] = v[high];
        v[high] = was;
    }
    return high + 1;
}

static void sort(double *v, size_t count, unsigned depth)
{
    while (count > FEW) {
        if (depth++ == DEEPEST) {
            qsort(v, count, sizeof *v, compare);
            return;
        }
        const size_t low = divide(v, count);
        sort(v, low, depth);
        v += low;
        count -= low;
    }
    insert(v, count);
}

void stp_sort_doubles(double *values, size_t count)
{
    sort(values, count, 0);
}
