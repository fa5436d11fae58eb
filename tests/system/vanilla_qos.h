/* The QoS of the test's nodes of plain Cyclone DDS, by the words reliable|best_effort volatile|latched DEPTH
   of their command lines. KIND is plain, or xcdr2, partition or other_hash: an endpoint that does not fit. */
#pragma once

#include <dds/dds.h>
#include <stdlib.h>
#include <string.h>

static inline dds_qos_t* vanilla_qos(char** words, const char* kind) {
  dds_qos_t* qos = dds_create_qos();
  const int reliable = strcmp(words[0], "reliable") == 0, latched = strcmp(words[1], "latched") == 0;
  const int depth = atoi(words[2]);
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(10));
  dds_qset_durability(qos, latched ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, depth);
  const dds_data_representation_id_t xcdr2 = DDS_DATA_REPRESENTATION_XCDR2;
  if (strcmp(kind, "xcdr2") == 0) dds_qset_data_representation(qos, 1, &xcdr2);
  const char* partition = "left";
  if (strcmp(kind, "partition") == 0) dds_qset_partition(qos, 1, &partition);
  const char* hash = "typehash=RIHS01_0;";
  if (strcmp(kind, "other_hash") == 0) dds_qset_userdata(qos, hash, strlen(hash));
  return qos;
}
