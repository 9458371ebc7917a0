// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace plumbline {

/// A web page with everything inside it, in the style of all reports.
/// @param title, subtitle  Plain text.
/// @param body             HTML.
std::string HtmlPage(const std::string& title, const std::string& subtitle,
                     const std::string& body);

/// Bytes as text for a web page.
std::string Base64(std::span<const std::uint8_t> bytes);

}  // namespace plumbline
