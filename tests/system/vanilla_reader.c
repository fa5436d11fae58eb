/* A node of plain Cyclone DDS, which knows nothing of SFT: it takes messages as C structs and writes what
   happens to its standard output, as records: { int64 stamp; uint32 kind, bytes; } and so many bytes.

   vanilla_reader DOMAIN TOPIC reliable|best_effort volatile|latched DEPTH KIND

   KIND is plain, or keyed, xcdr2, partition or other_hash: a reader that a publisher cannot serve. */
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "vanilla_messages.h"
#include "tests/system/vanilla_qos.h"

enum { matched = 1, sample = 2 }; /* kinds of records */

static void write_all(const void* bytes, size_t size) {
  for (size_t done = 0; done < size;) {
    const ssize_t n = write(STDOUT_FILENO, (const char*)bytes + done, size - done);
    if (n <= 0) exit(0); /* the test has ended */
    done += (size_t)n;
  }
}

static void report(uint32_t kind, int64_t stamp, const void* bytes, uint32_t size) {
  struct {
    int64_t stamp;
    uint32_t kind, size;
  } head = {stamp, kind, size};
  write_all(&head, sizeof head);
  write_all(bytes, size);
}

/* The struct once more as bytes, by Cyclone's own serializer. */
static void report_sample(const struct ddsi_serdata* as_received, const void* message, int64_t stamp) {
  struct ddsi_serdata* again = ddsi_serdata_from_sample(as_received->type, SDK_DATA, message);
  const uint32_t size = ddsi_serdata_size(again);
  char* bytes = malloc(size);
  ddsi_serdata_to_ser(again, 0, size, bytes);
  report(sample, stamp, bytes, size);
  free(bytes);
  ddsi_serdata_unref(again);
}

static void take_all(dds_entity_t reader) {
  static sensor_msgs_msg_dds__PointCloud2_ message;
  for (;;) {
    struct ddsi_serdata* as_received = NULL;
    dds_sample_info_t info;
    void* to = &message;
    if (dds_readcdr(reader, &as_received, 1, &info, DDS_ANY_STATE) <= 0) return;
    if (dds_take(reader, &to, &info, 1, 1) > 0 && info.valid_data)
      report_sample(as_received, &message, info.source_timestamp);
    ddsi_serdata_unref(as_received);
  }
}

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_topic_descriptor_t* type = strcmp(argv[6], "keyed") == 0
                                           ? &house_msgs_msg_dds__Room__desc
                                           : &sensor_msgs_msg_dds__PointCloud2__desc;
  const dds_entity_t topic = dds_create_topic(participant, type, argv[2], NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, topic, vanilla_qos(argv + 3, argv[6]), NULL);
  if (reader < 0) return 3;
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
  dds_waitset_attach(waitset, reader, 0);
  for (;;) {
    dds_attach_t triggered;
    dds_waitset_wait(waitset, &triggered, 1, DDS_INFINITY);
    dds_subscription_matched_status_t status;
    dds_get_subscription_matched_status(reader, &status);
    if (status.current_count_change != 0)
      report(matched, 0, &status.current_count, sizeof status.current_count);
    take_all(reader);
  }
}
