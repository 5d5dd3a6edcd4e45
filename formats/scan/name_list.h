/* Names of fields that are not read, as one line: "curvature, ring, ...". */
#ifndef STP_FORMATS_SCAN_NAME_LIST_H
#define STP_FORMATS_SCAN_NAME_LIST_H

#define STP_NAME_LIST_BYTES 4096u

/* Starts zeroed. Where it is full, it ends in an ellipsis. */
typedef struct stp_name_list {
    char text[STP_NAME_LIST_BYTES];
} stp_name_list;

/* Adds a name, once; an empty one is none. */
void stp_name_list_add(stp_name_list *list, const char *name);

#endif
