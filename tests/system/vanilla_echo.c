/* A node of plain Cyclone DDS, which knows nothing of SFT. It takes the clouds of one topic as C structs, and
   writes each of them to another topic. It writes the number of endpoints that match its own two to its
   standard output whenever that changes.

   vanilla_echo DOMAIN FROM TO reliable|best_effort volatile|latched DEPTH */
#include <dds/dds.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "vanilla_messages.h"
#include "tests/system/vanilla_qos.h"

static void tell_matched(dds_entity_t reader, dds_entity_t writer) {
  dds_subscription_matched_status_t writers;
  dds_publication_matched_status_t readers;
  dds_get_subscription_matched_status(reader, &writers);
  dds_get_publication_matched_status(writer, &readers);
  if (writers.current_count_change == 0 && readers.current_count_change == 0) return;
  const uint32_t matched = writers.current_count + readers.current_count;
  if (write(STDOUT_FILENO, &matched, sizeof matched) != sizeof matched) exit(0); /* the test has ended */
}

static void echo_all(dds_entity_t reader, dds_entity_t writer) {
  static sensor_msgs_msg_dds__PointCloud2_ message;
  void* to = &message;
  dds_sample_info_t info;
  while (dds_take(reader, &to, &info, 1, 1) > 0)
    if (info.valid_data && dds_write(writer, &message) != DDS_RETCODE_OK) exit(4);
}

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const dds_topic_descriptor_t* type = &sensor_msgs_msg_dds__PointCloud2__desc;
  const dds_entity_t from = dds_create_topic(participant, type, argv[2], NULL, NULL);
  const dds_entity_t to = dds_create_topic(participant, type, argv[3], NULL, NULL);
  dds_qos_t* qos = vanilla_qos(argv + 4, "plain");
  const dds_entity_t writer = dds_create_writer(participant, to, qos, NULL);
  const dds_entity_t reader = dds_create_reader(participant, from, qos, NULL);
  if (reader < 0 || writer < 0) return 3;
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
  dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS);
  dds_waitset_attach(waitset, reader, 0);
  dds_waitset_attach(waitset, writer, 0);
  for (;;) {
    dds_attach_t triggered[2];
    dds_waitset_wait(waitset, triggered, 2, DDS_INFINITY);
    tell_matched(reader, writer);
    echo_all(reader, writer);
  }
}
