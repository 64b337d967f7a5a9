#pragma once

#include <string>

namespace cousin {

/// Text that would run a script, or end an element, wherever a page took it for markup. A script
/// that runs sets data-hostile of the root element.
inline std::string hostile_text() {
  const std::string act = "document.documentElement.dataset.hostile=1";
  return "\"'><hostile></script></style></pre></title><script>" + act +
         "</script><img src=x onerror=" + act + "><svg onload=" + act +
         "><!--<script>--><a href=\"javascript:" + act + "\">]]>{{" + act +
         "}}\xe2\x80\xa8\xff\x1b[31m&lt;";
}

}  // namespace cousin
