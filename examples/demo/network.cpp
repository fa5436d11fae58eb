#include "examples/demo/network.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <sys/wait.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace sft::demo {

namespace {

tl::unexpected<Error> system_error(std::string_view what) {
  const Errc code = errno == EPERM || errno == EACCES ? Errc::no_permission : Errc::system;
  return fail(code, fmt::format("{}: {}", what, std::strerror(errno)));
}

Result<Descriptor> current_network() {
  Descriptor descriptor(open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC));
  if (!descriptor) return system_error("/proc/self/ns/net");
  return descriptor;
}

/// In the child of run(): does not return.
[[noreturn]] void execute(const NetworkNamespace& where, std::vector<std::string> command, int input,
                          int output) {
  if (Result<void> entered = where.enter(); !entered) {
    dprintf(output, "%s", entered.error().message.c_str());
    _exit(126);
  }
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  // `su` leaves the administrator's directories out.
  const char* path = std::getenv("PATH");
  setenv("PATH", fmt::format("{}:/usr/sbin:/sbin", path == nullptr ? "/usr/bin:/bin" : path).c_str(), 1);
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  dprintf(output, "%s cannot be run (%s); install the Debian packages iproute2 and ethtool", arguments[0],
          std::strerror(errno));
  _exit(127);
}

std::string read_all(int descriptor) {
  std::string text;
  char part[1024];
  for (;;) {
    const ssize_t bytes = read(descriptor, part, sizeof part);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) break;
    text.append(part, static_cast<std::size_t>(bytes));
  }
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

/// A bridge that passes on what the hosts send and adds nothing: no spanning tree, no queries, no IPv6
/// announcements.
Result<void> switch_on(const NetworkNamespace& network_switch) {
  return network_switch
      .run({"ip", "-batch", "-"},
           "link add name switch type bridge stp_state 0 mcast_snooping 0\n"
           "link set dev switch addrgenmode none\n"
           "link set dev switch up\n")
      // Where the kernel has bridges ask the firewall, that costs more than all the rest.
      .and_then([&] {
        return network_switch.run({"sh", "-c",
                                   "for f in /proc/sys/net/bridge/bridge-nf-call-*tables; do\n"
                                   "  ! [ -e \"$f\" ] || echo 0 >\"$f\" || :\n"
                                   "done"});
      });
}

}  // namespace

Result<NetworkNamespace> NetworkNamespace::create() {
  const Result<Descriptor> home = current_network();
  if (!home) return tl::unexpected(home.error());
  if (unshare(CLONE_NEWNET) != 0) return system_error("a network namespace cannot be made");
  Result<Descriptor> made = current_network();
  if (setns(home->get(), CLONE_NEWNET) != 0) {
    return system_error("the own network namespace cannot be entered again");
  }
  return std::move(made).map([](Descriptor&& descriptor) { return NetworkNamespace(std::move(descriptor)); });
}

Result<void> NetworkNamespace::enter() const {
  if (setns(descriptor_.get(), CLONE_NEWNET) == 0) return {};
  return system_error("a network namespace cannot be entered");
}

std::string NetworkNamespace::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), descriptor_.get());
}

Result<void> NetworkNamespace::run(const std::vector<std::string>& command, std::string_view input) const {
  int in[2];
  int out[2];
  if (pipe2(in, O_CLOEXEC) != 0) return system_error("pipe");
  const Descriptor in_read(in[0]);
  Descriptor in_write(in[1]);
  if (pipe2(out, O_CLOEXEC) != 0) return system_error("pipe");
  const Descriptor out_read(out[0]);
  Descriptor out_write(out[1]);

  const pid_t child = fork();
  if (child < 0) return system_error("fork");
  if (child == 0) execute(*this, command, in_read.get(), out_write.get());
  out_write = Descriptor();
  // A few lines: they fit into the pipe, whether the command reads them or not.
  const bool written =
      write(in_write.get(), input.data(), input.size()) == static_cast<ssize_t>(input.size());
  in_write = Descriptor();
  const std::string output = read_all(out_read.get());
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (written && WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return fail(Errc::system, fmt::format("the network cannot be set up: `{}` failed{}{}",
                                        fmt::join(command, " "), output.empty() ? "" : ": ", output));
}

std::string EmulatedNetwork::address(std::size_t number) { return fmt::format("10.77.0.{}", number + 1); }

Result<EmulatedNetwork> EmulatedNetwork::create(std::size_t hosts) {
  Result<NetworkNamespace> network_switch = NetworkNamespace::create();
  if (!network_switch) return tl::unexpected(network_switch.error());
  const Result<void> switched_on = switch_on(*network_switch);
  if (!switched_on) return tl::unexpected(switched_on.error());

  std::vector<NetworkNamespace> namespaces;
  for (std::size_t i = 0; i < hosts; ++i) {
    Result<NetworkNamespace> host = NetworkNamespace::create();
    if (!host) return tl::unexpected(host.error());
    namespaces.push_back(std::move(*host));
  }
  EmulatedNetwork network(std::move(*network_switch), std::move(namespaces));
  for (std::size_t i = 0; i < hosts; ++i) {
    if (Result<void> plugged = network.plug_in(i); !plugged) return tl::unexpected(plugged.error());
  }
  return network;
}

Result<void> EmulatedNetwork::plug_in(std::size_t number) const {
  const std::string port = fmt::format("port{}", number + 1);
  const NetworkNamespace& host = hosts_[number];
  return switch_
      .run({"ip", "-batch", "-"},
           fmt::format("link add name {0} mtu 1500 type veth peer name {1} mtu 1500 netns {2}\n"
                       "link set dev {0} addrgenmode none\n"
                       "link set dev {0} master switch\n"
                       "link set dev {0} up\n",
                       port, host_interface, host.path()))
      .and_then([&] {
        return host.run({"ip", "-batch", "-"}, fmt::format("link set dev lo up\n"
                                                           "link set dev {0} addrgenmode none\n"
                                                           "address add {1}/24 dev {0}\n"
                                                           "link set dev {0} up\n",
                                                           host_interface, address(number)));
      })
      // A virtual cable would carry a train of up to 44 datagrams as one packet and count one set of headers
      // for it. Cut into frames before the cable, as a network card does, every frame is counted with its
      // own.
      .and_then([&] {
        return host.run({"ethtool", "-K", host_interface, "tx-udp-segmentation", "off"});
      });
}

}  // namespace sft::demo
