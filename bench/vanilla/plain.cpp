#include "bench/vanilla/plain.h"

#include <ctime>
#include <utility>

namespace sft::bench {

namespace {

/// The receive buffer is large enough for one sample at once. The long lease keeps a stopped reader known.
constexpr const char* settings =
    "<Discovery><LeaseDuration>100 s</></>,"
    "<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/></>";
constexpr const char* topic_name = "rt/points";
constexpr std::int32_t depth = 10;  // the depth that is usual in ROS 2

CycloneQos reliable_qos() {
  CycloneQos qos(dds_create_qos(), dds_delete_qos);
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  return qos;
}

}  // namespace

PlainWriter::PlainWriter(std::uint32_t data_bytes)
    : participant_(settings),
      data_(data_bytes),
      writer_(participant_.writer(sensor_msgs_msg_dds__PointCloud2__desc, topic_name, reliable_qos().get())) {
}

void PlainWriter::write(std::uint32_t number) {
  const auto bytes = static_cast<std::uint32_t>(data_.size());
  sensor_msgs_msg_dds__PointCloud2_ cloud{};
  char no_frame[] = "";
  cloud.header_.frame_id_ = no_frame;
  cloud.height_ = number;
  cloud.data_._maximum = bytes;
  cloud.data_._length = bytes;
  cloud.data_._buffer = data_.data();
  checked(dds_write(writer_, &cloud));
}

PlainReader::PlainReader(std::function<void(std::uint32_t)> arrived)
    : participant_(settings),
      arrived_(std::move(arrived)),
      reader_(participant_.reader(
          sensor_msgs_msg_dds__PointCloud2__desc, topic_name, reliable_qos().get(),
          [](dds_entity_t reader, void* self) { static_cast<PlainReader*>(self)->take(reader); }, this)) {}

PlainReader::~PlainReader() { dds_delete(reader_); }  // Cyclone waits here for the end of the listener

void PlainReader::take(dds_entity_t reader) {
  void* to = &cloud_;
  dds_sample_info_t info;
  while (dds_take(reader, &to, &info, 1, 1) > 0) {
    if (info.valid_data) arrived_(cloud_.height_);
  }
}

std::int64_t process_cpu_ns() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace sft::bench
