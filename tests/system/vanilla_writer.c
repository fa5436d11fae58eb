/* A node of plain Cyclone DDS, which knows nothing of SFT. It reads lines "NUMBER BYTES", and writes for each
   of them a cloud with that number and so many bytes. It writes the number of matching readers to its
   standard output whenever that changes. At the end of its input it leaves.

   vanilla_writer DOMAIN TOPIC reliable|best_effort volatile|latched DEPTH KIND

   KIND is plain, or keyed, xcdr2, other_type, partition or other_hash: a writer that a subscriber cannot
   hear. With the kind "door" it writes doors with that number in place of clouds; with the kind "points"
   BYTES is the number of points, which have x, y, z and intensity. */
#include <dds/dds.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "vanilla_messages.h"
#include "tests/system/vanilla_qos.h"

static void report_matched(dds_entity_t writer, const dds_publication_matched_status_t status, void* unused) {
  (void)writer;
  (void)unused;
  const uint32_t readers = status.current_count;
  if (write(STDOUT_FILENO, &readers, sizeof readers) != sizeof readers) exit(0); /* the test has ended */
}

static void write_cloud(dds_entity_t writer, uint32_t number, uint32_t bytes) {
  sensor_msgs_msg_dds__PointField_ fields[2] = {{.name_ = ""}, {.name_ = "y"}};
  uint8_t* data = calloc(bytes, 1);
  for (uint32_t i = 0; i < bytes; i += 97) data[i] = (uint8_t)(i + number);
  const sensor_msgs_msg_dds__PointCloud2_ cloud = {
      .header_ = {.stamp_ = {.sec_ = (int32_t)number}, .frame_id_ = "lidar"},
      .height_ = number,
      .width_ = number + 1,
      .fields_ = {._maximum = 2, ._length = 2, ._buffer = fields},
      .point_step_ = 10,
      .row_step_ = 10 * (number + 1),
      .data_ = {._maximum = bytes, ._length = bytes, ._buffer = data}};
  if (dds_write(writer, &cloud) != DDS_RETCODE_OK) exit(4);
  free(data);
}

static void write_door(dds_entity_t writer, uint32_t number) {
  const house_msgs_msg_dds__Door_ door = {.number_ = number};
  if (dds_write(writer, &door) != DDS_RETCODE_OK) exit(4);
}

static void write_points(dds_entity_t writer, uint32_t number, uint32_t points) {
  sensor_msgs_msg_dds__PointField_ fields[4] = {
      {.name_ = "x"}, {.name_ = "y"}, {.name_ = "z"}, {.name_ = "intensity"}};
  for (uint32_t i = 0; i < 4; ++i) fields[i].offset_ = 4 * i, fields[i].datatype_ = 7, fields[i].count_ = 1;
  uint8_t* data = malloc(16 * points);
  for (uint32_t i = 0; i < 16 * points; ++i) data[i] = (uint8_t)(i * 7 + number);
  const sensor_msgs_msg_dds__PointCloud2_ cloud = {
      .header_ = {.stamp_ = {.sec_ = (int32_t)number}, .frame_id_ = ""},
      .height_ = 1,
      .width_ = points,
      .fields_ = {._maximum = 4, ._length = 4, ._buffer = fields},
      .point_step_ = 16,
      .row_step_ = 16 * points,
      .data_ = {._maximum = 16 * points, ._length = 16 * points, ._buffer = data}};
  if (dds_write(writer, &cloud) != DDS_RETCODE_OK) exit(4);
  free(data);
}

int main(int argc, char** argv) {
  if (argc != 7) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const dds_entity_t participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  const int is_other = strcmp(argv[6], "other_type") == 0, is_door = strcmp(argv[6], "door") == 0;
  const int is_keyed = strcmp(argv[6], "keyed") == 0;
  const dds_topic_descriptor_t* type = is_other   ? &std_msgs_msg_dds__Header__desc
                                       : is_door  ? &house_msgs_msg_dds__Door__desc
                                       : is_keyed ? &house_msgs_msg_dds__Room__desc
                                                  : &sensor_msgs_msg_dds__PointCloud2__desc;
  const dds_entity_t topic = dds_create_topic(participant, type, argv[2], NULL, NULL);
  dds_listener_t* listener = dds_create_listener(NULL);
  dds_lset_publication_matched(listener, report_matched);
  const dds_entity_t writer = dds_create_writer(participant, topic, vanilla_qos(argv + 3, argv[6]), listener);
  if (writer < 0) return 3;
  unsigned number, bytes;
  const int has_points = strcmp(argv[6], "points") == 0;
  void (*const write)(dds_entity_t, uint32_t, uint32_t) = has_points ? write_points : write_cloud;
  while (scanf("%u %u", &number, &bytes) == 2)
    is_door ? write_door(writer, number) : write(writer, number, bytes);
  dds_wait_for_acks(writer, DDS_SECS(10));
  dds_delete(participant);
  return 0;
}
