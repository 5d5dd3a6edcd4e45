/* The files of a report. */
#include "tools/tune/tune_report.h"

#include "base/json.h"
#include "base/memory.h"

#include <stdlib.h>

static stp_status write_text(const chart_text *text, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    STP_TRY(chart_text_check(text, err));
    STP_TRY(stp_output_create(&output, path, false, err));
    STP_TRY(stp_output_write(output, text->bytes, text->length, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

static stp_status write_csv(const tune_report *r, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    STP_TRY(stp_output_create(&output, path, false, err));
    STP_TRY(tune_csv_write(r->sweep, output, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

stp_status tune_report_write(const tune_report *r, tune_folder *folder, stp_error *err)
{
    static const char *const names[TUNE_CHARTS] = {"quality.svg", "times.svg", "promise.svg",
                                                   "popping.svg"};
    stp_status status = STP_OK;
    chart_text text = {0};
    STP_TRY(write_csv(r, tune_folder_file(folder, "tune.csv"), err));
    STP_TRY(stp_json_save(tune_json(r->sweep, r->answer, r->model_path, r->gl_renderer),
                          tune_folder_file(folder, "tune.json"), false, err));
    for (int i = 0; i < TUNE_CHARTS; i++) {
        text.length = 0;
        STP_TRY(tune_report_chart(r, i, &text, err));
        STP_TRY(write_text(&text, tune_folder_file(folder, names[i]), err));
    }
    text.length = 0;
    STP_TRY(tune_report_page(r, folder, &text, err));
    STP_TRY(write_text(&text, tune_folder_file(folder, "index.html"), err));
done:
    free(text.bytes);
    return status;
}
