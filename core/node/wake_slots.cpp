#include "core/node/wake_slots.h"

#include <numeric>
#include <string>

namespace sft::core {

namespace {
constexpr std::uint32_t shared_slots = 2;
constexpr std::uint32_t own_slots = DoorbellPage::slots - shared_slots;
}  // namespace

WakeSlots::WakeSlots() : page_(DoorbellPage::create()), free_(own_slots) {
  std::iota(free_.rbegin(), free_.rend(), shared_slots);
}

Result<std::uint32_t> WakeSlots::take() {
  const Lock lock(mutex_);
  if (free_.empty())
    return fail(Errc::limit_exceeded, "a node has at most " + std::to_string(own_slots) +
                                          " subscribers with neither callback nor file descriptor");
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slot;
}

void WakeSlots::give_back(std::uint32_t slot) {
  if (slot < shared_slots) return;
  const Lock lock(mutex_);
  free_.push_back(slot);
}

/// Rings the doorbells of free slots as well, because the list of free slots has a lock, which a signal
/// handler must not take.
void WakeSlots::interrupt() noexcept {
  interrupted_.store(true, std::memory_order_seq_cst);
  for (std::uint32_t slot = 0; slot < DoorbellPage::slots; ++slot) page_->at(slot).ring();
}

}  // namespace sft::core
