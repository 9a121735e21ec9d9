#include "bridges/web/page_files.hpp"

#include <algorithm>
#include <array>

#include "embedded/web_app_js.hpp"
#include "embedded/web_card_js.hpp"
#include "embedded/web_dial_js.hpp"
#include "embedded/web_dom_js.hpp"
#include "embedded/web_health_js.hpp"
#include "embedded/web_history_js.hpp"
#include "embedded/web_icon_svg.hpp"
#include "embedded/web_index_html.hpp"
#include "embedded/web_link_js.hpp"
#include "embedded/web_live_js.hpp"
#include "embedded/web_map_js.hpp"
#include "embedded/web_method_js.hpp"
#include "embedded/web_picture_js.hpp"
#include "embedded/web_plot_js.hpp"
#include "embedded/web_recording_js.hpp"
#include "embedded/web_recordings_js.hpp"
#include "embedded/web_style_css.hpp"
#include "embedded/web_words_js.hpp"

namespace slipd::web {
namespace {

constexpr std::string_view kCss = "text/css; charset=utf-8", kHtml = "text/html; charset=utf-8",
                           kScript = "text/javascript; charset=utf-8", kSvg = "image/svg+xml";

}  // namespace

std::span<const PageFile> page_files() {
  static const std::array kFiles{PageFile{"app.js", kScript, web_app_js},
                                 PageFile{"card.js", kScript, web_card_js},
                                 PageFile{"dial.js", kScript, web_dial_js},
                                 PageFile{"dom.js", kScript, web_dom_js},
                                 PageFile{"health.js", kScript, web_health_js},
                                 PageFile{"history.js", kScript, web_history_js},
                                 PageFile{"icon.svg", kSvg, web_icon_svg},
                                 PageFile{"index.html", kHtml, web_index_html},
                                 PageFile{"link.js", kScript, web_link_js},
                                 PageFile{"live.js", kScript, web_live_js},
                                 PageFile{"map.js", kScript, web_map_js},
                                 PageFile{"method.js", kScript, web_method_js},
                                 PageFile{"picture.js", kScript, web_picture_js},
                                 PageFile{"plot.js", kScript, web_plot_js},
                                 PageFile{"recording.js", kScript, web_recording_js},
                                 PageFile{"recordings.js", kScript, web_recordings_js},
                                 PageFile{"style.css", kCss, web_style_css},
                                 PageFile{"words.js", kScript, web_words_js}};
  return kFiles;
}

const PageFile* page_file(std::string_view path) {
  const auto files = page_files();
  const auto at =
      std::find_if(files.begin(), files.end(), [&](const PageFile& file) { return file.path == path; });
  return at == files.end() ? nullptr : &*at;
}

}  // namespace slipd::web
