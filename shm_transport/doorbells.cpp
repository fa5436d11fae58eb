#include "shm_transport/doorbells.h"

#include <algorithm>
#include <iterator>
#include <variant>

namespace sft::shm {

void Doorbells::add(std::shared_ptr<core::DoorbellPage> page, std::uint32_t slot) {
  core::Doorbell* bell = &page->at(slot);
  if (std::ranges::find(bells_, bell) != bells_.end()) return;
  bells_.push_back(bell);
  pages_.push_back(std::move(page));
}

void Doorbells::ring() const noexcept {
  for (core::Doorbell* bell : bells_) bell->ring();
}

std::shared_ptr<const Doorbells> DoorbellPages::doorbells_of(const std::vector<core::Route>& routes) {
  auto doorbells = std::make_shared<Doorbells>();
  for (const core::Route& route : routes) {
    const auto* address = std::get_if<core::DoorbellAddress>(&route.destination);
    if (address == nullptr || address->slot >= core::DoorbellPage::slots) continue;
    if (auto page = open(address->page)) doorbells->add(std::move(page), address->slot);
  }
  return doorbells;
}

std::shared_ptr<core::DoorbellPage> DoorbellPages::open(std::uint64_t id) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto known = pages_.find(id); known != pages_.end()) {
      if (auto page = known->second.lock()) return page;
    }
  }
  auto opened = core::DoorbellPage::open(id);
  if (!opened) return nullptr;
  std::shared_ptr<core::DoorbellPage> page = std::move(*opened);
  const std::scoped_lock lock(mutex_);
  std::erase_if(pages_, [](const auto& entry) { return entry.second.expired(); });
  pages_[id] = page;
  return page;
}

}  // namespace sft::shm
