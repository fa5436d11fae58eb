// Removes services from RouDi that have no port any more. RouDi keeps the name of each service that ever
// had a port: its introspection removes the ports, but not their service. Each publisher of SFT is a
// service of its own, so each publisher would cost the daemon 900 bytes for as long as it runs.
#pragma once

#include <iceoryx_posh/internal/roudi/port_manager.hpp>

namespace sft::shm {

/// Removes the services that have no port any more. Any thread may call this.
void forget_past_services(iox::roudi::PortManager& ports);

}  // namespace sft::shm
