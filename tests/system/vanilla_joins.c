/* Nodes of plain Cyclone DDS that come and go. For each line "NUMBER ROUNDS" of its input it does the
   following so many times: it opens a participant with a reader and a writer, whose QoS and types differ from
   round to round, waits until both are matched, writes a cloud with that number, and leaves. Then it writes
   the number of rounds in which both were matched to its standard output.

   vanilla_joins DOMAIN TOPIC */
#include <dds/dds.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "vanilla_messages.h"
#include "tests/system/vanilla_qos.h"

enum { kinds = 4, of_other_type = 3, timeout_s = 60 };
static char* qos_words[kinds][3] = {{"reliable", "volatile", "10"},
                                    {"best_effort", "volatile", "1"},
                                    {"reliable", "latched", "1"},
                                    {"reliable", "volatile", "10"}};

static int is_matched(dds_entity_t reader, dds_entity_t writer) {
  dds_subscription_matched_status_t writers;
  dds_publication_matched_status_t readers;
  dds_get_subscription_matched_status(reader, &writers);
  dds_get_publication_matched_status(writer, &readers);
  return writers.current_count > 0 && readers.current_count > 0;
}

static int join_and_leave(dds_domainid_t domain, const char* topic_name, unsigned round, unsigned number) {
  const unsigned kind = round % kinds;
  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  const dds_topic_descriptor_t* type =
      kind == of_other_type ? &house_msgs_msg_dds__Door__desc : &sensor_msgs_msg_dds__PointCloud2__desc;
  const dds_entity_t topic = dds_create_topic(participant, type, topic_name, NULL, NULL);
  dds_qos_t* qos = vanilla_qos(qos_words[kind], "plain");
  /* A reader and a writer of one participant match each other, too. */
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  const dds_entity_t writer = dds_create_writer(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (reader < 0 || writer < 0) exit(3);
  int matched = 0;
  const dds_time_t end = dds_time() + DDS_SECS(timeout_s);
  while (kind != of_other_type && !(matched = is_matched(reader, writer)) && dds_time() < end)
    dds_sleepfor(DDS_MSECS(1));
  if (matched) {
    const sensor_msgs_msg_dds__PointCloud2_ cloud = {.header_ = {.frame_id_ = ""}, .height_ = number};
    if (dds_write(writer, &cloud) != DDS_RETCODE_OK) exit(4);
    dds_wait_for_acks(writer, DDS_SECS(1));
  }
  dds_delete(participant);
  return matched || kind == of_other_type;
}

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  unsigned number, rounds;
  while (scanf("%u %u", &number, &rounds) == 2) {
    uint32_t joined = 0;
    for (unsigned round = 0; round < rounds; ++round)
      joined += join_and_leave((dds_domainid_t)atoi(argv[1]), argv[2], round, number);
    if (write(STDOUT_FILENO, &joined, sizeof joined) != sizeof joined) return 0; /* the test has ended */
  }
  return 0;
}
