#include "bench/common/sft_cloud.h"
#include "bench/common/node_options.h"

#include <algorithm>
#include <utility>

namespace sft::bench {

namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;

constexpr const char* topic = "points";

Node open(const char* name) { return Node::open(node_options(name, TransportChoice::shm)).value(); }

std::size_t served(const Publisher<PointCloud2>& publisher) {
  const std::vector<PublisherStatus::Reader> readers = publisher.status().readers;
  return static_cast<std::size_t>(std::ranges::count_if(readers, &PublisherStatus::Reader::served));
}

}  // namespace

SftLoanWriter::SftLoanWriter(std::uint32_t data_bytes)
    : node_(open("writer")),
      publisher_(node_.publisher<PointCloud2>(topic).value()),
      data_bytes_(data_bytes) {}

bool SftLoanWriter::serves(std::size_t readers) const { return served(publisher_) == readers; }

void SftLoanWriter::prepare(std::uint64_t number) {
  loan_ = publisher_.loan_for_overwrite(prototype_, {.data = data_bytes_}).value();
  loan_->set(F::width, static_cast<std::uint32_t>(number));
}

void SftLoanWriter::publish() { std::move(*loan_).publish(); }

SftOwnedWriter::SftOwnedWriter(std::uint32_t data_bytes)
    : node_(open("writer")),
      publisher_(node_.publisher<PointCloud2>(topic).value()),
      cloud_(cloud(data_bytes)) {}

bool SftOwnedWriter::serves(std::size_t readers) const { return served(publisher_) == readers; }

void SftOwnedWriter::prepare(std::uint64_t number) { cloud_.width = static_cast<std::uint32_t>(number); }

void SftOwnedWriter::publish() { publisher_.publish(cloud_); }

SftReader::SftReader()
    : node_(open("reader")),
      subscriber_(node_.subscriber<PointCloud2, F::height | F::width>(topic).value()) {}

std::uint64_t SftReader::take() {
  const auto sample = subscriber_.take();
  return sample ? std::uint64_t{sample->height()} * sample->width() : 0;
}

std::size_t SftReader::writers() const {
  const std::vector<SubscriberStatus::Writer> writers = subscriber_.status().writers;
  return static_cast<std::size_t>(std::ranges::count_if(writers, &SubscriberStatus::Writer::matched));
}

}  // namespace sft::bench
