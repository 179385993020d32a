// NKeys: Ed25519 keys as NATS writes them, base32 with a kind in front and a checksum behind.
#pragma once

#include <string>

namespace cylpose::cluster {

/// The public key (`U...`) of a user's seed (`SU...`). Throws Error(kInput) where it is none.
[[nodiscard]] std::string public_nkey(const std::string& seed);

}  // namespace cylpose::cluster
