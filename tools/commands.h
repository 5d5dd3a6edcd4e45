/* The commands of this build: each is one file in tools/ that defines cli_<name>.
 *
 * tools/CMakeLists.txt writes command_list.h: X(name) for each command in the order of the help. A
 * build without the renderer has fewer commands. */
#ifndef STP_TOOLS_COMMANDS_H
#define STP_TOOLS_COMMANDS_H

#include "tools/cli/cli.h"

#define X(name) extern const cli_command cli_##name;
#include "command_list.h"
#undef X

#endif
