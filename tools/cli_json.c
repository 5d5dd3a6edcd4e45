/* JSON as an output file. */
#include "base/file.h"
#include "tools/cli.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <string.h>

stp_status cli_write_json(const char *path, struct cJSON *json, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    char *text = json != NULL ? cJSON_Print(json) : NULL;
    cJSON_Delete(json);
    if (text == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", path);
    STP_TRY(stp_output_create(&output, path, true, err));
    STP_TRY(stp_output_write(output, text, strlen(text), err));
    STP_TRY(stp_output_write(output, "\n", 1, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    free(text);
    return status;
}
