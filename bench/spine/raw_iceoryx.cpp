// The references in shared memory: iceoryx as its own examples use it, 16 bytes a message.
#include <iceoryx_hoofs/log/logmanager.hpp>
#include <iceoryx_posh/popo/publisher.hpp>
#include <iceoryx_posh/popo/subscriber.hpp>
#include <iceoryx_posh/popo/wait_set.hpp>
#include <iceoryx_posh/runtime/posh_runtime.hpp>
#include <string>

#include "bench/spine/spine.h"

namespace sft::bench {

namespace {

struct Message {
  std::uint64_t number;
  std::uint64_t filling;
};

/// sftd serves only names that begin with "sft_".
void init(const char* name) {
  iox::log::LogManager::GetLogManager().SetDefaultLogLevel(iox::log::LogLevel::kOff,
                                                           iox::log::LogLevelOutput::kHideLogLevel);
  iox::runtime::PoshRuntime::initRuntime(
      iox::RuntimeName_t(iox::cxx::TruncateToCapacity, std::string(name) + std::to_string(getpid())));
}

const iox::capro::ServiceDescription service{"bench", "spine", "raw"};

void send(Exchange& exchange, std::uint64_t messages, std::int64_t pause) {
  init("sft_raw_sender_");
  iox::popo::Publisher<Message> publisher(service);
  while (!exchange.ready.load() || !publisher.hasSubscribers()) {
  }
  for (std::uint64_t i = 0; i < messages; ++i) {
    pause_us(pause);
    publisher.loan().and_then([&](auto& sample) {
      sample->number = i + 1;
      exchange.sent_at[i] = now_ns();
      sample.publish();
    });
    if (!exchange.wait_for_receipt(i + 1)) {
      exchange.failed = true;
      return;
    }
  }
}

template <class Wait>
void receive(Exchange& exchange, std::uint64_t messages, iox::popo::Subscriber<Message>& subscriber,
             Wait wait) {
  exchange.ready = true;
  for (std::uint64_t next = 1; next <= messages && !exchange.failed;) {
    wait();
    subscriber.take().and_then([&](auto& sample) {
      next = sample->number + 1;
      exchange.received_at[sample->number - 1] = now_ns();
      exchange.received.store(sample->number, std::memory_order_release);
    });
  }
}

}  // namespace

std::vector<double> raw_iceoryx_waitset(std::uint64_t messages) {
  return run_pair(
      {.sender = [=](Exchange& e) { send(e, messages, 150); },
       .receiver =
           [=](Exchange& e) {
             init("sft_raw_receiver_");
             iox::popo::Subscriber<Message> subscriber(service);
             iox::popo::WaitSet<> wait_set;
             wait_set.attachState(subscriber, iox::popo::SubscriberState::HAS_DATA).or_else([](auto) {});
             receive(e, messages, subscriber, [&] { wait_set.wait(); });
           }},
      messages);
}

std::vector<double> raw_iceoryx_polling(std::uint64_t messages) {
  return run_pair({.sender = [=](Exchange& e) { send(e, messages, 5); },
                   .receiver =
                       [=](Exchange& e) {
                         init("sft_raw_receiver_");
                         iox::popo::Subscriber<Message> subscriber(service);
                         receive(e, messages, subscriber, [] {});
                       }},
                  messages);
}

}  // namespace sft::bench
