#pragma once

#include <seater_msgs/DockInUse.h>

#include <cstdint>
#include <string>

#include "seater_perception/dock_layout.h"

namespace seater_perception {

/// Which dock is looked for: that of the parameters until the docking node names another one.
class DockChoice {
 public:
  /// `name`: of the dock in `layout`; empty where the parameters do not say.
  DockChoice(DockLayout layout, std::string name);

  /// Whether other markers are looked for from now on than before. Throws ConfigurationError, naming file and key, for
  /// a dock that cannot be used; the one before stays.
  bool take(const seater_msgs::DockInUse& message);

  const DockLayout& layout() const { return layout_; }
  const std::string& name() const { return name_; }
  std::uint32_t revision() const { return revision_; }  ///< as in DockInUse; 0: of the parameters

 private:
  DockLayout layout_;
  std::string name_;
  std::uint32_t revision_ = 0;
};

}  // namespace seater_perception
