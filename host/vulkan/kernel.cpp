#include "vulkan/kernel.h"

#include <array>

namespace viewpeel {
namespace {

VkDescriptorSetLayout createTexelLayout(VkDevice device, uint32_t count) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (uint32_t k = 0; k < count; ++k)
    bindings.push_back({k, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
  VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
  info.bindingCount = count;
  info.pBindings = bindings.data();
  VkDescriptorSetLayout layout = VK_NULL_HANDLE;
  check(vkCreateDescriptorSetLayout(device, &info, nullptr, &layout), "vkCreateDescriptorSetLayout");
  return layout;
}

VkPipelineLayout createLayout(VkDevice device, VkShaderStageFlags stages, uint32_t push_bytes,
                              VkDescriptorSetLayout texels = VK_NULL_HANDLE) {
  const VkPushConstantRange range{stages, 0, push_bytes};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.pushConstantRangeCount = 1;
  info.pPushConstantRanges = &range;
  info.setLayoutCount = texels ? 1 : 0;
  info.pSetLayouts = &texels;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  check(vkCreatePipelineLayout(device, &info, nullptr, &layout), "vkCreatePipelineLayout");
  return layout;
}

}  // namespace

ShaderModule::ShaderModule(const Device& device, std::span<const uint32_t> spirv) : device_(device.handle()) {
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = spirv.size_bytes();
  info.pCode = spirv.data();
  check(vkCreateShaderModule(device_, &info, nullptr, &module_), "vkCreateShaderModule");
}

VkPipelineShaderStageCreateInfo ShaderModule::stage(VkShaderStageFlagBits stage) const {
  VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage = stage;
  info.module = module_;
  info.pName = "main";
  return info;
}

Pipeline::~Pipeline() {
  vkDestroyPipeline(device, handle, nullptr);
  vkDestroyPipelineLayout(device, layout, nullptr);
  vkDestroyDescriptorSetLayout(device, texels, nullptr);
}

std::shared_ptr<const Pipeline> ComputePipelines::find(const Device& device, std::span<const uint32_t> spirv,
                                                       uint32_t push_bytes, const std::vector<uint32_t>& constants,
                                                       uint32_t texel_buffers) {
  const std::lock_guard lock(mutex_);
  std::shared_ptr<const Pipeline>& found = made_[{spirv.data(), push_bytes, constants, texel_buffers}];
  if (found) return found;
  const auto made = std::make_shared<Pipeline>(device.handle());
  const ShaderModule module(device, spirv);
  if (texel_buffers) made->texels = createTexelLayout(made->device, texel_buffers);
  made->layout = createLayout(made->device, VK_SHADER_STAGE_COMPUTE_BIT, push_bytes, made->texels);
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = module.stage(VK_SHADER_STAGE_COMPUTE_BIT);
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t k = 0; k < constants.size(); ++k) entries.push_back({k, k * 4, 4});
  const VkSpecializationInfo specialisation{static_cast<uint32_t>(entries.size()), entries.data(), constants.size() * 4,
                                            constants.data()};
  if (!constants.empty()) info.stage.pSpecializationInfo = &specialisation;
  info.layout = made->layout;
  check(vkCreateComputePipelines(made->device, VK_NULL_HANDLE, 1, &info, nullptr, &made->handle),
        "vkCreateComputePipelines");
  return found = made;
}

Kernel::Kernel(const Device& device, std::span<const uint32_t> spirv, uint32_t push_bytes,
               const std::vector<uint32_t>& constants, uint32_t texel_buffers)
    : made_(device.pipelines().find(device, spirv, push_bytes, constants, texel_buffers)),
      stages_(VK_SHADER_STAGE_COMPUTE_BIT) {}

Kernel::Kernel(const Device& device, std::span<const uint32_t> vertex_spirv, std::span<const uint32_t> fragment_spirv,
               VkFormat colour, VkFormat depth, uint32_t push_bytes, VkCompareOp nearer)
    : stages_(VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT) {
  const auto made = std::make_shared<Pipeline>(device.handle());
  const ShaderModule vertex(device, vertex_spirv), fragment(device, fragment_spirv);
  const std::array stages = {vertex.stage(VK_SHADER_STAGE_VERTEX_BIT), fragment.stage(VK_SHADER_STAGE_FRAGMENT_BIT)};
  made->layout = createLayout(made->device, stages_, push_bytes);
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.colorAttachmentCount = 1;
  rendering.pColorAttachmentFormats = &colour;
  rendering.depthAttachmentFormat = depth;
  VkPipelineVertexInputStateCreateInfo vertex_input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.lineWidth = 1;
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth_state{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth_state.depthTestEnable = depth_state.depthWriteEnable = VK_TRUE;
  depth_state.depthCompareOp = nearer;
  VkPipelineColorBlendAttachmentState attachment{};
  attachment.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT;
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = 1;
  blend.pAttachments = &attachment;
  const std::array dynamics = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = dynamics.size();
  dynamic.pDynamicStates = dynamics.data();

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
  info.stageCount = stages.size();
  info.pStages = stages.data();
  info.pVertexInputState = &vertex_input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth_state;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = made->layout;
  check(vkCreateGraphicsPipelines(made->device, VK_NULL_HANDLE, 1, &info, nullptr, &made->handle),
        "vkCreateGraphicsPipelines");
  made_ = made;
}

}  // namespace viewpeel
