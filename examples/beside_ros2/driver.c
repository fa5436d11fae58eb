/* driver: a robot's driver as DDS sees it in a graph of ROS 2. It is written for Cyclone DDS and knows
   nothing of SFT. It writes ten scans per second of a wall ahead of the robot, and drives as it is told. It
   ends one second after the robot has stopped, or if nobody commands it for a minute. */
#include <dds/dds.h>
#include <stdio.h>
#include <stdlib.h>

#include "ros_messages.h"

enum { beams = 360 };

int main(void) {
  const char* domain = getenv("ROS_DOMAIN_ID");
  const dds_entity_t node = dds_create_participant(domain ? (dds_domainid_t)atoi(domain) : 0, NULL, NULL);
  const dds_entity_t scans = dds_create_writer(
      node, dds_create_topic(node, &sensor_msgs_msg_dds__LaserScan__desc, "rt/scan", NULL, NULL), NULL, NULL);
  const dds_entity_t commands = dds_create_reader(
      node, dds_create_topic(node, &geometry_msgs_msg_dds__Twist__desc, "rt/cmd_vel", NULL, NULL), NULL,
      NULL);
  if (scans < 0 || commands < 0) return fprintf(stderr, "Cyclone DDS cannot be opened\n"), 1;

  float ranges[beams], distance = 3;
  double speed = 0;
  geometry_msgs_msg_dds__Twist_ command;
  void* taken = &command;
  dds_sample_info_t info;
  int stopped = -1; /* scans since the robot has stopped; -1: it has never driven */
  for (int i = 0; i < 600 && stopped < 10; ++i) {
    for (int beam = 0; beam < beams; ++beam) ranges[beam] = distance;
    const sensor_msgs_msg_dds__LaserScan_ scan = {
        .header_ = {.stamp_ = {.sec_ = i / 10}, .frame_id_ = "laser"},
        .angle_max_ = 6.28F,
        .angle_increment_ = 6.28F / beams,
        .range_max_ = 10,
        .ranges_ = {._maximum = beams, ._length = beams, ._buffer = ranges}};
    dds_write(scans, &scan);
    dds_sleepfor(DDS_MSECS(100));
    while (dds_take(commands, &taken, &info, 1, 1) > 0) {
      if (!info.valid_data || command.linear_.x_ == speed) continue;
      speed = command.linear_.x_;
      printf("driver: %.1f m/s, %.2f m before the wall\n", speed, distance);
      fflush(stdout);
      stopped = speed == 0 ? 0 : -1;
    }
    if (stopped >= 0) ++stopped;
    distance -= (float)speed / 10;
  }
  dds_delete(node);
  return stopped < 0;
}
