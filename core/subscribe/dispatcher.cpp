#include "core/subscribe/dispatcher.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sft::core {

Dispatcher::~Dispatcher() {
  if (!thread_.joinable()) return;
  stopping_.store(true);
  bell_.ring();
  thread_.join();
}

Result<void> Dispatcher::start() {
  const Lock lock(mutex_);
  if (thread_.joinable()) return {};
  auto started = start_thread(spec_, [this] { run(); });
  if (!started) return tl::unexpected(started.error());
  thread_ = std::move(*started);
  return {};
}

void Dispatcher::add(std::shared_ptr<SubscriberCore> subscriber) {
  const Lock lock(mutex_);
  auto more = std::make_shared<Subscribers>(*subscribers_);
  more->push_back(std::move(subscriber));
  subscribers_ = std::move(more);
}

void Dispatcher::remove(const SubscriberCore& subscriber) {
  const Lock lock(mutex_);
  auto fewer = std::make_shared<Subscribers>(*subscribers_);
  std::erase_if(*fewer, [&](const auto& s) { return s.get() == &subscriber; });
  subscribers_ = std::move(fewer);
}

std::shared_ptr<const Dispatcher::Subscribers> Dispatcher::subscribers() const {
  const Lock lock(mutex_);
  return subscribers_;
}

void Dispatcher::run() {
  thread_id_.store(std::this_thread::get_id());
  const auto forever = std::chrono::steady_clock::time_point::max();
  while (!stopping_.load()) {
    {
      const auto present = subscribers();
      for (const auto& subscriber : *present) {
        in_turn_.store(subscriber.get());
        subscriber->dispatch();
      }
      in_turn_.store(nullptr);
    }
    bell_.wait(forever, [this] {
      if (stopping_.load()) return true;
      const auto present = subscribers();
      return std::any_of(present->begin(), present->end(),
                         [](const auto& s) { return s->waits_for_dispatch(); });
    });
  }
}

}  // namespace sft::core
