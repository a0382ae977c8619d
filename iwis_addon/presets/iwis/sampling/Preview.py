import bpy

iwis = bpy.context.scene.iwis

iwis.estimator = "UNBIASED"
iwis.stop_rule = "PERCEPTUAL"
iwis.error_threshold = 0.3
iwis.max_samples = 32
iwis.target_samples = 64
iwis.time_limit = 0.0
iwis.batch_size = 8
iwis.coefficients = 0.05
iwis.pixel_filter = "CENTER"
iwis.filter_width = 1.5
iwis.decorrelation = "OWEN"
