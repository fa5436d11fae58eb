#include "examples/demo/protocol.h"

#include <fmt/format.h>

namespace sft::demo {

void refuse(Channel& channel, const Error& error) {
  if (channel.receive({}).event == Channel::Event::message) channel.send({{"error", error.message}});
}

Result<nlohmann::json> detail::ask(Channel& channel, std::string_view role, const Order& order,
                                   Clock::duration patience) {
  channel.send(order);
  Channel::Received answer = channel.receive(Clock::now() + patience);
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
