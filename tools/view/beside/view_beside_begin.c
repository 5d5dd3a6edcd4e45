/* Begins with both sides, and prepares their scans. */
#include "tools/view/beside/view_beside.h"
#include "tools/view/prepare/view_prepare.h"
#include "tools/view/view_wishes.h"

stp_status view_beside_begin(viewer *v, stp_error *err)
{
    stp_error why = {0};
    const stp_status status = view_beside_both(v, view_scene_changed, &why);
    if (status != STP_OK)
        return stp_error_set(
            err, status, "%s%s", why.message,
            status == STP_LIMIT && v->beside.other.options ? ", for each of the sides" : "");
    v->beside.linked = v->control.params;
    view_beside_join_ranges(v);
    return STP_OK;
}

void view_beside_prepare(viewer *v)
{
    const int here = v->beside.here;
    for (int side = 0; side <= (v->beside.other.options ? 1 : 0); side++) {
        view_beside_use(v, side);
        if (v->beside.other.prepare.state != VIEW_PREPARE_RUNNING)
            view_prepare_turn(v);
    }
    view_beside_use(v, here);
}
