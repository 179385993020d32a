#include "nkey.hpp"

#include <openssl/evp.h>

#include <array>
#include <cstdint>
#include <cylpose/cluster/connection.hpp>
#include <cylpose/error.hpp>
#include <memory>
#include <vector>

namespace cylpose::cluster {
namespace {

constexpr std::size_t kKeyBytes = 32;
// First bits of what is encoded: they become the letters S and U.
constexpr std::uint8_t kSeed = 18 << 3;
constexpr std::uint8_t kUser = 20 << 3;

constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZ234567";

using Octets = std::vector<std::uint8_t>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

// CRC-16 with polynomial 0x1021, from 0.
std::uint16_t checksum(const Octets& octets) {
  unsigned crc = 0;
  for (const std::uint8_t octet : octets) {
    crc ^= unsigned{octet} << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000U) != 0 ? (crc << 1) ^ 0x1021U : crc << 1;
  }
  return static_cast<std::uint16_t>(crc);
}

std::string base32(const Octets& octets) {
  std::string text;
  unsigned bits = 0;
  int count = 0;
  for (const std::uint8_t octet : octets) {
    bits = bits << 8 | octet;
    for (count += 8; count >= 5; count -= 5) text += kAlphabet[bits >> (count - 5) & 31U];
  }
  if (count > 0) text += kAlphabet[bits << (5 - count) & 31U];
  return text;
}

Octets from_base32(std::string_view text) {
  Octets octets;
  unsigned bits = 0;
  int count = 0;
  for (const char letter : text) {
    const std::size_t value = kAlphabet.find(letter);
    if (value == std::string_view::npos) return {};
    bits = bits << 5 | static_cast<unsigned>(value);
    count += 5;
    if (count < 8) continue;
    count -= 8;
    octets.push_back(static_cast<std::uint8_t>(bits >> count & 255U));
  }
  return octets;
}

std::string with_checksum(Octets octets) {
  const std::uint16_t sum = checksum(octets);
  octets.push_back(static_cast<std::uint8_t>(sum & 255U));
  octets.push_back(static_cast<std::uint8_t>(sum >> 8));
  return base32(octets);
}

std::string public_of(const Key& key) {
  Octets octets(1 + kKeyBytes);
  octets[0] = kUser;
  std::size_t size = kKeyBytes;
  if (key == nullptr || EVP_PKEY_get_raw_public_key(key.get(), octets.data() + 1, &size) != 1 || size != kKeyBytes) {
    throw Error(ErrorKind::kDevice, "libcrypto: no Ed25519 public key of that seed");
  }
  return with_checksum(octets);
}

}  // namespace

std::string public_nkey(const std::string& seed) {
  const Octets octets = from_base32(seed);
  // Two octets hold the kinds (seed, and of what), two the checksum.
  if (octets.size() != 2 + kKeyBytes + 2 || with_checksum({octets.begin(), octets.end() - 2}) != seed ||
      octets[0] != (kSeed | kUser >> 5) || (octets[1] & 0xF8U) != (kUser << 3 & 0xF8U)) {
    throw Error(ErrorKind::kInput, "this is no seed of a user's NKey; it begins with SU and has 58 letters and digits");
  }
  const Key key(EVP_PKEY_new_raw_private_key(EVP_PKEY_ED25519, nullptr, octets.data() + 2, kKeyBytes), EVP_PKEY_free);
  return public_of(key);
}

NKey make_nkey() {
  EVP_PKEY* made = nullptr;
  const std::unique_ptr<EVP_PKEY_CTX, decltype(&EVP_PKEY_CTX_free)> context(
      EVP_PKEY_CTX_new_id(EVP_PKEY_ED25519, nullptr), EVP_PKEY_CTX_free);
  if (context == nullptr || EVP_PKEY_keygen_init(context.get()) != 1 || EVP_PKEY_keygen(context.get(), &made) != 1) {
    throw Error(ErrorKind::kDevice, "libcrypto: cannot make an Ed25519 key");
  }
  const Key key(made, EVP_PKEY_free);
  Octets octets(2 + kKeyBytes);
  octets[0] = kSeed | kUser >> 5;
  octets[1] = static_cast<std::uint8_t>(kUser << 3 & 0xF8U);
  std::size_t size = kKeyBytes;
  if (EVP_PKEY_get_raw_private_key(key.get(), octets.data() + 2, &size) != 1) {
    throw Error(ErrorKind::kDevice, "libcrypto: cannot read the Ed25519 key it made");
  }
  return {with_checksum(octets), public_of(key)};
}

}  // namespace cylpose::cluster
