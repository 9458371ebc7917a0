// SPDX-License-Identifier: Apache-2.0
#include "app/report/html_page.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/report/svg_plot.h"

namespace plumbline {
namespace {

constexpr const char* kStyle = R"(
body{font:15px/1.5 system-ui,sans-serif;color:#1c242c;background:#f6f7f8;margin:0}
main{max-width:1060px;margin:0 auto;padding:28px 24px 60px}
h1{font-size:26px;margin:0 0 2px} h2{font-size:18px;margin:34px 0 10px}
p.sub{color:#66727e;margin:0 0 18px}
.cards{display:flex;flex-wrap:wrap;gap:10px}
.card{background:#fff;border:1px solid #e2e6ea;border-radius:8px;padding:10px 16px;min-width:108px}
.card b{display:block;font-size:20px} .card span{color:#66727e;font-size:13px}
table{border-collapse:collapse;background:#fff;width:100%;font-size:13.5px}
th,td{padding:5px 9px;border-bottom:1px solid #e8ebee;text-align:right;white-space:nowrap}
th{color:#66727e;font-weight:600} th:first-child,td:first-child,td.l,th.l{text-align:left}
.scroll{overflow-x:auto;border:1px solid #e2e6ea;border-radius:8px}
figure{margin:0} figcaption{color:#66727e;font-size:13px;padding:4px 2px 0}
.pictures{display:grid;grid-template-columns:1fr 1fr;gap:14px} img{width:100%;border-radius:6px;display:block}
svg{background:#fff;border:1px solid #e2e6ea;border-radius:8px;max-width:100%;height:auto;margin:0 0 12px}
svg text{font:11px system-ui,sans-serif;fill:#66727e} svg text.title{font-size:13px;font-weight:600;fill:#1c242c}
svg .grid{stroke:#eceff1} .dot{display:inline-block;width:10px;height:10px;border-radius:3px;margin-right:6px}
.bad{color:#b3372a} .good{color:#1f7d55} .legend{font-size:13px;color:#66727e} .legend span{margin-right:14px;white-space:nowrap}
details{background:#fff;border:1px solid #e2e6ea;border-radius:8px;padding:8px 14px;margin:8px 0} summary{cursor:pointer}
pre{font-size:12.5px;overflow-x:auto;margin:8px 0})";

}  // namespace

std::string HtmlPage(const std::string& title, const std::string& subtitle,
                     const std::string& body) {
  return fmt::format(
      "<!doctype html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
      "content='width=device-width'><title>{0}</title><style>{1}</style></head><body><main>"
      "<h1>{0}</h1><p class='sub'>{2}</p>{3}</main></body></html>\n",
      Escaped(title), kStyle, Escaped(subtitle), body);
}

std::string Base64(std::span<const std::uint8_t> bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    const std::uint32_t bits =
        bytes[i] << 16 | (left > 1 ? bytes[i + 1] << 8 : 0) | (left > 2 ? bytes[i + 2] : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= left ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

}  // namespace plumbline
