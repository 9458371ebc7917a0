// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace plumbline {

/// A detector that 'plumbline networks get' fetches.
struct ListedDetector {
  std::string name, about;
  std::string file;           ///< "": it has not been fetched.
  std::string fetching = {};  ///< How far that is, while it is being fetched.
  std::string problem = {};   ///< Why it could not be fetched, in one sentence.
};

/// What a network file that the user named is.
struct NetworkFile {
  std::string file;                  ///< "": none was named.
  bool known = false;                ///< Else it is being looked at.
  std::string problem;               ///< Why it cannot be used, in one sentence; "": it can.
  bool edges = false;                ///< It finds edges, else objects.
  std::string what;                  ///< "yolox, 416 x 416 px, 80 categories"
  bool guessed = false;              ///< It has no sidecar yet.
  std::vector<std::string> reasons;  ///< Of the guess, one sentence each.
};

/// Networks that there are besides those of the program.
struct NetworksView {
  std::vector<ListedDetector> detectors;  ///< The best first.
  NetworkFile file;
};

}  // namespace plumbline
