// A value that is computed at most once, without a lock.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

namespace sft::detail {

/// Bytes that are computed when a thread first asks for them, and are then kept. Any thread may use an
/// object.
class BytesOnDemand {
 public:
  using Bytes = std::vector<std::byte>;

  BytesOnDemand() = default;
  BytesOnDemand(BytesOnDemand&& other) noexcept : bytes_(other.bytes_.exchange(nullptr)) {}
  BytesOnDemand& operator=(BytesOnDemand&& other) noexcept {
    delete bytes_.exchange(other.bytes_.exchange(nullptr));
    return *this;
  }
  ~BytesOnDemand() { delete bytes_.load(); }

  template <class Make>
  const Bytes& get(Make make) {
    if (const Bytes* made = bytes_.load(std::memory_order_acquire)) return *made;
    auto mine = std::make_unique<const Bytes>(make());
    const Bytes* known = nullptr;
    if (!bytes_.compare_exchange_strong(known, mine.get(), std::memory_order_acq_rel)) return *known;
    return *mine.release();
  }

 private:
  std::atomic<const Bytes*> bytes_{nullptr};
};

}  // namespace sft::detail
