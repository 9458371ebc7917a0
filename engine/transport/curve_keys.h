// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// The keys by which the nodes of a graph know one another (CurveZMQ: everything is encrypted, and
/// whoever has no key of the folder is refused). Text of 40 characters, Z85.
struct CurveKeys {
  std::string own_name;
  std::string own_public, own_secret;
  std::map<std::string, std::string> public_of;  ///< By name, the own one included.
};

/// Makes a pair for a node: NAME.public, to be copied to all machines, and NAME.secret, readable by
/// its owner alone, which stays. Errors: kIo; kInvalidInput for a name that is none, or that has
/// keys already.
Status MakeCurveKeys(const std::filesystem::path& folder, const std::string& name);

/// The secret of `name` and all public keys of a folder. Errors: kNotFound, kCorrupt, kIo;
/// kInvalidInput where others may read the secret.
Result<CurveKeys> ReadCurveKeys(const std::filesystem::path& folder, const std::string& name);

}  // namespace plumbline
