#include "shm_transport/wake/doorbell_pages.h"

#include <variant>

namespace sft::shm {

namespace {
constexpr std::chrono::milliseconds search_interval{500};
}

Result<std::shared_ptr<core::DoorbellPage>> DoorbellPages::page_of(const core::Route& route,
                                                                   const core::TrustedAccounts& accounts) {
  const auto* address = std::get_if<core::DoorbellAddress>(&route.destination);
  if (address == nullptr || address->slot >= core::DoorbellPage::slots)
    return fail(Errc::malformed, "the reader has announced a doorbell that cannot exist");
  return open(address->page, accounts);
}

std::shared_ptr<const Doorbells> DoorbellPages::doorbells_of(const std::vector<core::Route>& routes,
                                                             const core::TrustedAccounts& accounts) {
  auto doorbells = std::make_shared<Doorbells>();
  for (const core::Route& route : routes) {
    const auto* address = std::get_if<core::DoorbellAddress>(&route.destination);
    if (address == nullptr || address->slot >= core::DoorbellPage::slots) continue;
    doorbells->add(open(address->page, accounts).value_or(nullptr), address->slot, route.gate);
  }
  if (doorbells->size() > 1) waker_.start();
  return doorbells;
}

/// Returns the link to a page that has no path, or an empty text. The search goes through all processes. So
/// it is done at most once in `search_interval`, however many nonexistent pages other nodes announce.
std::string DoorbellPages::nameless_link(std::uint64_t id) {
  const auto now = std::chrono::steady_clock::now();
  if (now >= next_search_) {
    nameless_ = core::DoorbellPage::nameless_pages();
    next_search_ = now + search_interval;
  }
  const auto found = nameless_.find(id);
  return found == nameless_.end() ? "" : found->second;
}

Result<std::shared_ptr<core::DoorbellPage>> DoorbellPages::open(std::uint64_t id,
                                                                const core::TrustedAccounts& accounts) {
  {
    const core::Lock lock(mutex_);
    if (const auto known = pages_.find(id); known != pages_.end()) {
      if (auto page = known->second.lock()) return page;
    }
  }
  auto opened = core::DoorbellPage::open(id, accounts);
  if (!opened && opened.error().code == Errc::unavailable) {
    if (const std::string link = nameless_link(id); !link.empty())
      opened = core::DoorbellPage::open_nameless(id, link);
  }
  if (!opened) return tl::unexpected(opened.error());
  std::shared_ptr<core::DoorbellPage> page = std::move(*opened);
  const core::Lock lock(mutex_);
  std::erase_if(pages_, [](const auto& entry) { return entry.second.expired(); });
  pages_[id] = page;
  return page;
}

}  // namespace sft::shm
