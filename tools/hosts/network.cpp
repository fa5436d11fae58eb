#include "tools/hosts/network.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>

#include "tools/hosts/child_process.h"
#include "tools/hosts/system_error.h"

namespace sft::hosts {

namespace {

Result<core::FileDescriptor> current_network() {
  core::FileDescriptor descriptor(open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC));
  if (!descriptor) return system_error("/proc/self/ns/net");
  return descriptor;
}

/// Returns a file in memory with this text. Reading begins at its first byte.
Result<core::FileDescriptor> file_with(std::string_view text) {
  core::FileDescriptor file(memfd_create("input", MFD_CLOEXEC));
  const bool written =
      file && write(file.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (!written || lseek(file.get(), 0, SEEK_SET) != 0) return system_error("a file in memory cannot be made");
  return file;
}

/// Executes the command in place of this process. Returns only if the command cannot be run.
Result<void> execute(std::vector<std::string> command, int input, int output) {
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(output, STDERR_FILENO);
  // `su` leaves the administrator's directories out of PATH, so they are added.
  const char* path = std::getenv("PATH");
  setenv("PATH", fmt::format("{}:/usr/sbin:/sbin", path == nullptr ? "/usr/bin:/bin" : path).c_str(), 1);
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  return fail(Errc::system,
              fmt::format("{} cannot be run ({}); install the Debian packages iproute2 and ethtool",
                          command[0], std::strerror(errno)));
}

/// Makes a bridge that forwards the frames of the hosts and sends no frames of its own: no spanning tree,
/// no queries, no IPv6 announcements.
Result<void> switch_on(const NetworkNamespace& network_switch) {
  return network_switch
      .run({"ip", "-batch", "-"},
           "link add name switch type bridge stp_state 0 mcast_snooping 0\n"
           "link set dev switch addrgenmode none\n"
           "link set dev switch up\n")
      // Turns off the firewall for bridged frames. Otherwise the kernel spends more time there than on all
      // other work.
      .and_then([&] {
        return network_switch.run({"sh", "-c",
                                   "for f in /proc/sys/net/bridge/bridge-nf-call-*tables; do\n"
                                   "  ! [ -e \"$f\" ] || echo 0 >\"$f\" || :\n"
                                   "done"});
      });
}

}  // namespace

Result<NetworkNamespace> NetworkNamespace::create() {
  const Result<core::FileDescriptor> home = current_network();
  if (!home) return tl::unexpected(home.error());
  if (unshare(CLONE_NEWNET) != 0) return system_error("a network namespace cannot be made");
  Result<core::FileDescriptor> made = current_network();
  if (setns(home->get(), CLONE_NEWNET) != 0) {
    return system_error("the own network namespace cannot be entered again");
  }
  return std::move(made).map(
      [](core::FileDescriptor&& descriptor) { return NetworkNamespace(std::move(descriptor)); });
}

Result<void> NetworkNamespace::enter() const {
  if (setns(descriptor_.get(), CLONE_NEWNET) == 0) return {};
  return system_error("a network namespace cannot be entered");
}

std::string NetworkNamespace::path() const {
  return fmt::format("/proc/{}/fd/{}", getpid(), descriptor_.get());
}

Result<void> NetworkNamespace::run(const std::vector<std::string>& command, std::string_view input) const {
  const Result<core::FileDescriptor> file = file_with(input);
  if (!file) return tl::unexpected(file.error());
  return in_child([&](int output) {
           return enter().and_then([&] { return execute(command, file->get(), output); });
         })
      .map_error([&](const Error& error) {
        return Error{Errc::system,
                     fmt::format("the network cannot be set up: `{}` failed{}{}", fmt::join(command, " "),
                                 error.message.empty() ? "" : ": ", error.message)};
      });
}

std::string EmulatedNetwork::address(std::size_t number) { return fmt::format("10.77.0.{}", number + 1); }

std::string EmulatedNetwork::port(std::size_t number) { return fmt::format("port{}", number + 1); }

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
  const NetworkNamespace& host = hosts_[number];
  return switch_
      .run({"ip", "-batch", "-"},
           fmt::format("link add name {0} mtu 1500 type veth peer name {1} mtu 1500 netns {2}\n"
                       "link set dev {0} addrgenmode none\n"
                       "link set dev {0} master switch\n"
                       "link set dev {0} up\n",
                       port(number), host_interface, host.path()))
      .and_then([&] {
        return host.run({"ip", "-batch", "-"}, fmt::format("link set dev lo up\n"
                                                           "link set dev {0} addrgenmode none\n"
                                                           "address add {1}/24 dev {0}\n"
                                                           "link set dev {0} up\n",
                                                           host_interface, address(number)));
      })
      // A virtual cable would carry a train of up to 44 datagrams as one packet and count one set of
      // headers for it. So the host cuts trains into frames before the cable, as a network card does, and
      // every frame is counted with its own headers.
      .and_then([&] {
        return host.run({"ethtool", "-K", host_interface, "tx-udp-segmentation", "off"});
      });
}

}  // namespace sft::hosts
