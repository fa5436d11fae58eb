#include "shm_transport/wake/doorbells.h"

#include <algorithm>
#include <iterator>

namespace sft::shm {

void Doorbells::add(std::shared_ptr<core::DoorbellPage> page, std::uint32_t slot,
                    std::shared_ptr<const core::Gate> gate) {
  core::Doorbell* bell = page == nullptr ? nullptr : &page->at(slot);
  auto known = std::ranges::find(bells_, bell, &Bell::bell);
  if (known == bells_.end()) {
    bells_.emplace_back().bell = bell;
    known = std::prev(bells_.end());
    pages_.push_back(std::move(page));
  }
  known->always |= gate == nullptr;
  if (gate != nullptr) known->gates.push_back(std::move(gate));
}

bool Doorbells::Bell::wanted() const noexcept {
  return always || std::ranges::any_of(gates, [](const auto& gate) { return gate->passes(); });
}

bool Doorbells::wanted() const noexcept { return std::ranges::any_of(bells_, &Bell::wanted); }

std::size_t Doorbells::announce() const noexcept {
  std::size_t sleepers = 0;
  for (const Bell& bell : bells_) {
    if (bell.bell == nullptr || !bell.wanted() || !bell.bell->announce()) continue;
    bell.wake_due.store(true, std::memory_order_release);
    ++sleepers;
  }
  return sleepers;
}

void Doorbells::wake() const noexcept {
  for (const Bell& bell : bells_) {
    // A reader that has woken up meanwhile checks for samples before it sleeps again, and needs no wake-up.
    if (bell.wake_due.exchange(false, std::memory_order_acq_rel) && bell.bell->has_sleepers())
      bell.bell->wake();
  }
}

}  // namespace sft::shm
