//! The pipelines of the example, made from the text and the layouts that the scene gives.

use crate::stage::Corner;
use trimtess::out::wgpu::LiveScene;
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, CompareFunction, RenderPipeline, TextureView};

pub(crate) const SIZE: (u32, u32) = (1280, 960);
/// Texels along a side of the shadow map.
pub(crate) const SHADOW: u32 = 2048;
pub(crate) const SAMPLES: u32 = 4;
pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
pub(crate) const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Pipelines, and what they read besides the scene.
pub(crate) struct Material {
    pub(crate) model: RenderPipeline,
    pub(crate) model_shadow: RenderPipeline,
    pub(crate) other: RenderPipeline,
    pub(crate) other_shadow: RenderPipeline,
    /// `Light` in the shader.
    pub(crate) light: wgpu::Buffer,
    pub(crate) lit: BindGroup,
    pub(crate) shadow_map: TextureView,
    pub(crate) shadowed: BindGroup,
}

impl Material {
    pub(crate) fn new(device: &wgpu::Device, scene: &LiveScene) -> Self {
        let light = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("light"),
            size: 96,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let shadow_map = texture(device, (SHADOW, SHADOW), DEPTH, 1, wgpu::TextureUsages::TEXTURE_BINDING);
        let shadow_map = shadow_map.create_view(&wgpu::TextureViewDescriptor::default());
        // Depth is reversed: what is as near to the light as the map says, or nearer, is lit.
        let comparing = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            compare: Some(CompareFunction::GreaterEqual),
            ..wgpu::SamplerDescriptor::default()
        });
        let uniform = BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let depths = BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let compares = BindingType::Sampler(wgpu::SamplerBindingType::Comparison);
        let (of_light, lit) = bound(device, [(uniform, light.as_entire_binding())]);
        let map = BindingResource::TextureView(&shadow_map);
        let (of_shadows, shadowed) = bound(device, [(depths, map), (compares, BindingResource::Sampler(&comparing))]);

        // The scene's text first, then the example's own.
        let input = scene.surface_input();
        let shaders = Shaders {
            device,
            module: device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("own material"),
                source: wgpu::ShaderSource::Wgsl([input.wgsl, include_str!("material.wgsl")].concat().into()),
            }),
            groups: [&input.bind_group, &of_light, &of_shadows],
        };
        let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3];
        let corners = [Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Corner>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &attributes,
        })];
        Self {
            model: shaders.pipeline("model", Some("model_fragment"), &input.vertex_buffers),
            model_shadow: shaders.pipeline("model_shadow", None, &input.vertex_buffers),
            other: shaders.pipeline("other", Some("other_fragment"), &corners),
            other_shadow: shaders.pipeline("other_shadow", None, &corners),
            light,
            lit,
            shadow_map,
            shadowed,
        }
    }
}

struct Shaders<'a> {
    device: &'a wgpu::Device,
    module: wgpu::ShaderModule,
    groups: [&'a BindGroupLayout; 3],
}

impl Shaders<'_> {
    /// A pipeline for the picture, or without fragments for the shadow map, which the map is no input of.
    fn pipeline(
        &self,
        vertex: &str,
        fragment: Option<&str>,
        buffers: &[Option<wgpu::VertexBufferLayout<'_>>],
    ) -> RenderPipeline {
        let (groups, count) = if fragment.is_some() { (&self.groups[..], SAMPLES) } else { (&self.groups[..2], 1) };
        let groups: Vec<_> = groups.iter().copied().map(Some).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let targets = [Some(COLOUR.into())];
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(vertex),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count, ..wgpu::MultisampleState::default() },
            fragment: fragment.map(|fragment| wgpu::FragmentState {
                module: &self.module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A bind group of resources, in order, and its layout.
fn bound<const N: usize>(
    device: &wgpu::Device,
    resources: [(BindingType, BindingResource<'_>); N],
) -> (BindGroupLayout, BindGroup) {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let types = resources.iter().zip(0..);
    let types: Vec<_> = types
        .map(|((ty, _), binding)| wgpu::BindGroupLayoutEntry { binding, visibility, ty: *ty, count: None })
        .collect();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &types });
    let entries = resources.into_iter().zip(0..);
    let entries: Vec<_> = entries.map(|((_, resource), binding)| wgpu::BindGroupEntry { binding, resource }).collect();
    let group =
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries });
    (layout, group)
}

/// A texture to draw to.
pub(crate) fn texture(
    device: &wgpu::Device,
    (width, height): (u32, u32),
    format: wgpu::TextureFormat,
    sample_count: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
        view_formats: &[],
    })
}
