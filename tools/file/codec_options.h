/* The options --codec and --format of commands that write chunk files. */
#ifndef STP_TOOLS_FILE_CODEC_OPTIONS_H
#define STP_TOOLS_FILE_CODEC_OPTIONS_H

#include "formats/chunk/chunk_file.h"

/* The first is the default of prep. */
#define CODEC_CHOICES "draco|zstd|raw"

/* A choice's index is its version less 1. The first is the default of prep. */
#define FORMAT_CHOICES "1|2"

/* Converts the index of a choice to the codec. */
static inline stp_codec codec_options_codec(int choice)
{
    static const stp_codec codecs[] = {STP_CODEC_DRACO, STP_CODEC_ZSTD, STP_CODEC_RAW};
    return codecs[choice];
}

#endif
