/* A list of fields that are not read, as one line: "curvature, ring, ...". */
#ifndef STP_FORMATS_SCAN_NAME_LIST_H
#define STP_FORMATS_SCAN_NAME_LIST_H

#define STP_NAME_LIST_BYTES 4096u

/* Starts zeroed. If the list is full, it ends in an ellipsis. */
typedef struct stp_name_list {
    char text[STP_NAME_LIST_BYTES];
} stp_name_list;

/* Adds a name if it is not in the list. Ignores an empty name. */
void stp_name_list_add(stp_name_list *list, const char *name);

#endif
