/* Checks output files before the work. */
#include "base/file.h"
#include "tools/cli/cli.h"

stp_status cli_check_outputs(const char *const outputs[CLI_OUTPUT_LIMIT], const char *const *inputs,
                             size_t input_count, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *probes[CLI_OUTPUT_LIMIT] = {NULL};
    for (size_t i = 0; i < CLI_OUTPUT_LIMIT; i++) {
        if (outputs[i] == NULL)
            continue;
        for (size_t k = 0; k < input_count; k++)
            if (inputs[k] != NULL)
                STP_TRY(stp_output_check_input(outputs[i], inputs[k], err));
        for (size_t k = 0; k < i; k++)
            if (probes[k] != NULL)
                STP_TRY(stp_output_check_other(probes[k], outputs[i], err));
        STP_TRY(stp_output_create(&probes[i], outputs[i], force, err));
    }
done:
    for (size_t i = 0; i < CLI_OUTPUT_LIMIT; i++)
        stp_output_destroy(&probes[i]);
    return status;
}
