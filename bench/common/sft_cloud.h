// Point clouds in shared memory with SFT, with the interface of transfer.h.
#pragma once

#include <sft/sft.h>

#include <optional>

#include "bench/common/cloud.h"

namespace sft::bench {

/// Publishes loans. Does not write the data of a cloud.
class SftLoanWriter {
 public:
  explicit SftLoanWriter(std::uint32_t data_bytes);

  bool serves(std::size_t readers) const;
  void prepare(std::uint64_t number);
  void publish();

 private:
  Node node_;
  Publisher<sensor_msgs::msg::PointCloud2> publisher_;
  const sensor_msgs::msg::PointCloud2 prototype_ = cloud(0);
  const std::uint32_t data_bytes_;
  std::optional<Loan<sensor_msgs::msg::PointCloud2>> loan_;
};

/// Publishes a message in the program's own memory.
class SftOwnedWriter {
 public:
  explicit SftOwnedWriter(std::uint32_t data_bytes);

  bool serves(std::size_t readers) const;
  void prepare(std::uint64_t number);
  void publish();

 private:
  Node node_;
  Publisher<sensor_msgs::msg::PointCloud2> publisher_;
  sensor_msgs::msg::PointCloud2 cloud_;
};

/// Reads the height and width of a cloud.
class SftReader {
  using F = sensor_msgs::msg::PointCloud2::Field;

 public:
  SftReader();

  void wait() { subscriber_.wait(std::chrono::seconds(1)); }
  std::uint64_t take();
  std::size_t writers() const;

 private:
  Node node_;
  Subscriber<sensor_msgs::msg::PointCloud2, F::height | F::width> subscriber_;
};

}  // namespace sft::bench
