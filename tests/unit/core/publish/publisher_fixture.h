// A publisher of one type. Its port keeps the last sample, in memory that other samples have used before.
#pragma once

#include <cstring>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/publish/publisher_core.h"
#include "sft/publisher.h"
#include "tests/unit/core/seam/idle_ports.h"

namespace sft::core::test {

class KeepingPort final : public IdleNetworkWriter {
 public:
  SampleHandle last;

 private:
  SendStatus send_begun(const SampleHandle& sample, Reach) noexcept override {
    last = sample;
    return SendStatus::sent;
  }
};

/// The value with which memory is filled before it is lent.
inline constexpr std::byte canary{0xA5};

template <class T>
class PublisherOf {
 public:
  PublisherOf() {
    const TypeSupport& type = type_support<T>();
    auto core =
        std::make_shared<PublisherCore>(PublisherCore::Spec{1, "topic", &type, 1 << 24}, pool_, port_);
    Serving serving;
    serving.network = {Route{2, UdpAddress{}, type.full()}};
    core->serve(serving, nullptr);
    publisher_.emplace(detail::untyped::Publisher(std::move(core)));
  }

  Publisher<T>* operator->() { return &*publisher_; }

  /// Releases the last sample and overwrites all memory of the pool, in blocks of up to 1 MiB.
  void poison_memory() {
    port_->last.reset();
    std::vector<SampleHandle> all;
    for (std::size_t bytes = 512; bytes <= 1 << 20; bytes *= 2) {
      for (int i = 0; i < 3; ++i) all.push_back(pool_->take(bytes));
    }
    for (const SampleHandle& buffer : all)
      std::memset(buffer->data, std::to_integer<int>(canary), buffer->capacity);
  }

  bool has_sent() const { return static_cast<bool>(port_->last); }
  SampleBuffer& sent() { return *port_->last; }
  std::vector<std::byte> sent_body() {
    const std::byte* body = sent().data + sent().header().body_offset;
    return {body, body + sent().header().body_bytes};
  }

 private:
  std::shared_ptr<BufferPool> pool_ = BufferPool::make(64 << 20);
  std::shared_ptr<KeepingPort> port_ = std::make_shared<KeepingPort>();
  std::optional<Publisher<T>> publisher_;
};

}  // namespace sft::core::test
