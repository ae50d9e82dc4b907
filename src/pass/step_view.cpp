#include "pass/step_view.h"

namespace fumarole::pass {

NearLight::NearLight(glm::dvec3 position, const Frame& frame, double near)
{
    const glm::dvec4 view = frame.view_from_world * glm::dvec4(position, 1.0);
    const glm::dvec4 clip = frame.clip_from_view * view;
    least = glm::length(glm::dvec3(view));
    view_z = -view.z;
    if (!(-view.z > near) || !(clip.w > 0))
        return;
    const glm::dvec2 size(frame.color.size);
    pixel = (glm::dvec2(clip) / clip.w * 0.5 + 0.5) * size;
    metres = 2 * clip.w / (frame.clip_from_view[1][1] * size.y);
    least = 0;
}

StepView::StepView(const PreparedFrame& of)
    : frame{of}, slots{of}, scale{static_cast<double>(of.settings.resolution)},
      offset{of.host.layer_offset - glm::dvec2(of.layer_guard)},
      reach{of.settings.upsample == Settings::Upsample::bilinear2x2 ? 1.0 : 2.0}
{
}

double far_share(double g)
{
    constexpr double kFar = 0.25;
    // The lobe is ((1 - g)^2 + g theta^2)^(-3/2), about.
    return kFar * std::min(1.0, (1 - g) / std::sqrt(std::max(g, 1e-6)));
}

float longest_step(double detail, double most)
{
    constexpr double kDetail = 2;    // of what it changes within
    constexpr double kFaint = 0.02;  // optical depth of a step that changes are lost in
    constexpr double kThick = 0.3;   // that a step is to have at most
    return static_cast<float>(std::min(std::max(kDetail * detail, kFaint / most), kThick / most));
}

}  // namespace fumarole::pass
