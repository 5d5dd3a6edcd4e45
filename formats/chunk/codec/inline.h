/* Functions that are part of a loop: the compiler must not leave them as calls. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_INLINE_H
#define STP_FORMATS_CHUNK_CODEC_INLINE_H

#define STP_INLINE static inline __attribute__((always_inline))

#endif
