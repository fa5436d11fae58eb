/* Many nodes of plain Cyclone DDS in one process, which know nothing of SFT. Each of them has several pairs
   of a reader and a writer, and writes the clouds of "rt/in_N" to "rt/out_N", where N counts the pairs of all
   nodes from 0. Once all pairs are there, the program writes their number to its standard output.

   vanilla_many DOMAIN NODES PAIRS */
#include <dds/dds.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "tests/system/vanilla_qos.h"
#include "vanilla_messages.h"

static char* qos_words[] = {"reliable", "volatile", "10"};

/* A listener of the reader, whose argument is the writer. */
static void echo(dds_entity_t reader, void* writer) {
  sensor_msgs_msg_dds__PointCloud2_ message = {.height_ = 0};
  void* to = &message;
  dds_sample_info_t info;
  while (dds_take(reader, &to, &info, 1, 1) > 0)
    if (info.valid_data && dds_write((dds_entity_t)(intptr_t)writer, &message) != DDS_RETCODE_OK) exit(4);
  dds_sample_free(&message, &sensor_msgs_msg_dds__PointCloud2__desc, DDS_FREE_CONTENTS);
}

static dds_entity_t topic_of(dds_entity_t participant, const char* way, unsigned number) {
  char name[32];
  snprintf(name, sizeof name, "rt/%s_%u", way, number);
  return dds_create_topic(participant, &sensor_msgs_msg_dds__PointCloud2__desc, name, NULL, NULL);
}

static void add_pair(dds_entity_t participant, unsigned number) {
  dds_qos_t* qos = vanilla_qos(qos_words, "plain");
  const dds_entity_t writer = dds_create_writer(participant, topic_of(participant, "out", number), qos, NULL);
  dds_listener_t* listener = dds_create_listener((void*)(intptr_t)writer);
  dds_lset_data_available(listener, echo);
  if (dds_create_reader(participant, topic_of(participant, "in", number), qos, listener) < 0) exit(3);
  dds_delete_listener(listener);
  dds_delete_qos(qos);
}

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const unsigned nodes = (unsigned)atoi(argv[2]), pairs = (unsigned)atoi(argv[3]);
  for (unsigned node = 0; node < nodes; ++node) {
    const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
    if (participant < 0) return 3;
    for (unsigned pair = 0; pair < pairs; ++pair) add_pair(participant, node * pairs + pair);
  }
  const uint32_t made = nodes * pairs;
  if (write(STDOUT_FILENO, &made, sizeof made) != sizeof made) return 0; /* the test has ended */
  for (;;) pause();
}
