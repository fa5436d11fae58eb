#include "tools/demo/roles/protocol.h"

#include <fmt/format.h>

#include <algorithm>

namespace sft::demo {

namespace {

constexpr std::chrono::milliseconds between_looks{100};

}  // namespace

void refuse(Channel& channel, const Error& error) {
  if (channel.receive({}).event == Channel::Event::message) channel.send({{"error", error.message}});
}

Result<nlohmann::json> detail::ask(Channel& channel, std::string_view role, const Order& order,
                                   Clock::duration timeout, const WhileWaiting& while_waiting) {
  channel.send(order);
  const auto deadline = Clock::now() + timeout;
  const auto next_look = [&] { return while_waiting ? Clock::now() + between_looks : deadline; };
  Channel::Received answer = channel.receive(std::min(deadline, next_look()));
  while (answer.event == Channel::Event::timeout && Clock::now() < deadline) {
    if (while_waiting) {
      if (Result<void> go_on = while_waiting(); !go_on) return tl::unexpected(go_on.error());
    }
    answer = channel.receive(std::min(deadline, next_look()));
  }
  switch (answer.event) {
    case Channel::Event::closed:
      return fail(Errc::unavailable, fmt::format("the process of the {} has ended unexpectedly", role));
    case Channel::Event::timeout:
      return fail(Errc::unavailable, fmt::format("the process of the {} does not answer", role));
    case Channel::Event::message:
      break;
  }
  if (const auto error = answer.message.find("error"); error != answer.message.end()) {
    return fail(Errc::system, fmt::format("{}: {}", role, error->get<std::string>()));
  }
  return std::move(answer.message);
}

}  // namespace sft::demo
